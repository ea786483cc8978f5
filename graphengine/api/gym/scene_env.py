"""The Gymnasium environment of a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.spaces import Box, Dict
from gymnasium.vector import AsyncVectorEnv
from numpy.typing import NDArray

from graphengine.api.gym.actuations import BaseVelocity, JointTargets
from graphengine.api.gym.observations import Observation
from graphengine.api.scene import Scene
from graphengine.api.values import check_choice
from graphengine.format.errors import UsageError

Action = BaseVelocity | JointTargets
PATIENCE = 5.0
"""Longest time that a reset waits for the first messages of observed topics, s of simulation."""


class SceneEnv(gymnasium.Env[Any, NDArray[Any]]):
    """A Gymnasium environment that steps a session of a scene.

    Actions are vectors of numbers from -1 to 1, which are scaled to the limits of the commands; numbers beyond are clipped.
    Observations are clipped to their limits, so that the infinite range of a beam without a hit becomes the greatest range.

    >>> env = ge.gym.SceneEnv(
    ...     ge.load("dd100_flat"),
    ...     action=ge.gym.BaseVelocity("/dd100_0000/cmd_vel"),
    ...     observation=ge.gym.Observation("/dd100_0000/odom.pose.pose.position", low=-10.0, high=10.0),
    ...     reward=lambda env: -abs(env.sim.robots["dd100"].pose.position[0] - 1.0),
    ...     ticks=6,
    ... )
    >>> observation, info = env.reset(seed=3)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
    >>> env.close()

    Args:
        scene: scene, made by `load`.
        action: command of each step; the numbers of several commands are joined.
        observation: what is observed; a mapping gives a `Dict` space.
        reward: function that returns the reward of the step that has just ended.
        terminated: function that returns whether the episode has ended. `TimeLimit` of `gymnasium.wrappers` limits the steps.
        truncated: function that returns whether the episode is given up.
        at_reset: function that each reset calls at time 0, for example to move a robot; `env.np_random` is its random generator.
        ticks: number of ticks in a step.
        render_mode: `rgb_array`, or None to render nothing.
        view: view or camera to render, as for `Session.picture`.
        size: width and height of rendered images, pixels.

    Attributes:
        sim: session of the environment, transport `memory`; `close` closes it.
        observation: newest observation.
        action: newest action as given; all 0 after `reset`.

    Raises:
        GraphError: the session cannot start, does not have an address, robot or joint, or an argument is invalid.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}  # noqa: RUF012

    def __init__(
        self,
        scene: Scene,
        *,
        action: Action | Sequence[Action],
        observation: Observation | Mapping[str, Observation],
        reward: Callable[[SceneEnv], float],
        terminated: Callable[[SceneEnv], bool] = lambda env: False,
        truncated: Callable[[SceneEnv], bool] = lambda env: False,
        at_reset: Callable[[SceneEnv], object] = lambda env: None,
        ticks: int = 1,
        render_mode: str | None = None,
        view: str = "perspective",
        size: tuple[int, int] = (640, 480),
    ) -> None:
        given = {name: value for name, value in locals().items() if name not in ("self", "__class__")}
        check_choice("render_mode", render_mode or "None", [*self.metadata["render_modes"], "None"])
        if ticks < 1:
            raise UsageError(f"ticks: expected 1 or more, got {ticks}")
        self.spec = EnvSpec("graphengine/SceneEnv-v0", lambda **changed: SceneEnv(**{**given, **changed}))
        self.render_mode = render_mode
        self._reward, self._terminated, self._truncated, self._at_reset = reward, terminated, truncated, at_reset
        self._ticks, self._view, self._size = ticks, view, size
        self._observation = observation if isinstance(observation, Mapping) else {"": observation}
        self.sim = scene.session()
        try:
            self._open([action] if isinstance(action, Action) else action)
        except BaseException:
            self.close()
            raise
        ends = self._limits.items()
        spaces: dict[str, Any] = {name: Box(low, high, dtype=low.dtype.type) for name, (low, high) in ends}
        self.observation_space = Dict(spaces) if self._observation is observation else spaces[""]
        self.action_space = Box(-1.0, 1.0, (len(self._names),))
        self.metadata = {**self.metadata, "render_fps": round(1.0 / (ticks * self._period), 3)}

    def _open(self, actions: Sequence[Action]) -> None:
        """Find actions and observations in the session."""
        self._period = self.sim._runner.session.clock.delta
        self._start = self.sim.checkpoint()
        self._actuations = [each._open(self.sim) for each in actions]
        self._names = [name for each in self._actuations for name in each.names]
        self._signals = {name: each._open(self.sim) for name, each in self._observation.items()}
        self._await_messages()
        self._limits = {name: signal.limits() for name, signal in self._signals.items()}

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Restore the state at time 0, and run ticks until all observed topics have sent a message, at least one tick.

        Args:
            seed: seed of `np_random` and of all random generators of the session; None draws the latter from `np_random`.
            options: not used.

        Raises:
            UsageError: a topic has sent no message after 5 s of simulation.
        """
        super().reset(seed=seed)
        self.sim.restore(self._start, seed=int(self.np_random.integers(2**31)) if seed is None else seed)
        for signal in self._signals.values():
            signal.restart()
        self.action = np.zeros(len(self._names), np.float32)
        self._at_reset(self)
        self._await_messages()
        self.observation = self._observe()
        return self.observation, {}

    def step(self, action: NDArray[Any]) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Send the commands, run the ticks of a step, and return what `gymnasium.Env.step` returns, with an empty `info`.

        Raises:
            NodeError: a node raised an exception.
            PhysicsError: the simulation diverged.
            UsageError: the action has another number of elements.
        """
        self._act(action)
        self.sim.step(self._ticks)
        self.observation = self._observe()
        reward, ended = float(self._reward(self)), (bool(self._terminated(self)), bool(self._truncated(self)))
        return self.observation, reward, *ended, {}

    def render(self) -> NDArray[np.uint8] | None:
        """Return an image of the world, of shape (height, width, 3); None without a render mode.

        Raises:
            RenderError: OpenGL is missing or failed.
        """
        return self.sim.picture(self._view, size=self._size) if self.render_mode else None

    def close(self) -> None:
        """Close the session. Safe to call twice."""
        self.sim.close()

    def _act(self, action: NDArray[Any]) -> None:
        self.action = action
        shares = (np.clip(np.asarray(action, np.float64), -1.0, 1.0) + 1.0) / 2.0
        if shares.shape != (len(self._names),):
            raise UsageError(f"action: expected a number for each of {self._names}, got shape {shares.shape}")
        for each in self._actuations:
            share, shares = np.split(shares, [len(each.names)])
            low, high = each.limits
            each.send(low + share * (high - low))

    def _await_messages(self) -> None:
        for _ in range(round(PATIENCE / self._period)):
            self.sim.step()
            missing = [signal.name for signal in self._signals.values() if signal.read() is None]
            if not missing:
                return
        raise UsageError(f"{missing[0]}: no message within {PATIENCE:g} s of simulation after a reset")

    def _observe(self) -> Any:
        observed = {}
        for name, (low, high) in self._limits.items():
            array = self._signals[name].array()
            if array.shape != low.shape:
                source = self._signals[name].name
                raise UsageError(f"{source}: shape {array.shape}, at the start {low.shape}; it must stay the same")
            observed[name] = np.clip(array, low, high)
        return observed[""] if isinstance(self.observation_space, Box) else observed


def make_vec(make: Callable[[], gymnasium.Env[Any, Any]], count: int) -> AsyncVectorEnv:
    """Return a vector of environments, each in a new process. Call it below `if __name__ == "__main__":`.

    >>> envs = ge.gym.make_vec(lambda: TimeLimit(ge.gym.SceneEnv(scene, **task), 200), 4)  # doctest: +SKIP

    Args:
        make: function that makes an environment. It is pickled, with the objects that it uses, such as a `Scene`.
        count: number of environments.
    """
    return AsyncVectorEnv([make] * count, context="spawn")
