"""Steps, resets, saves and restores a simulation. Handles and sensors use this class."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Self

import numpy as np

from graphengine.descriptions.engine import Floats, model_bytes, mujoco
from graphengine.format.stateful import Stateful
from graphengine.physics.core.handle_table import Handle
from graphengine.physics.core.simulation_model import STATE, SimulationModel
from graphengine.physics.dynamics.held_bodies import HeldBody
from graphengine.physics.dynamics.settling import settle as settle_bodies
from graphengine.physics.dynamics.solver_errors import begin_step, diverged, gave_up
from graphengine.physics.dynamics.start_state import initial_data


@dataclass(frozen=True, slots=True)
class SavedState:
    """The state of a simulation in a checkpoint.

    Attributes:
        counts: the attributes that `SimulationCore.kept` names: seed, start state, and numbers of ticks, steps and other events.
        data: MuJoCo's state.
        mounts: poses of the bodies that are fixed to the world and were moved.
        gravity: acceleration of free fall in the world frame, m/s2.
        parts: states of set points, force limits, pushes, written frictions, written lights, moving surfaces, welds and faults.
        surfaces: names of the bodies that have moving surfaces.
        handles: state of each handle, for example sensor samples; the keys are handle class and handle key.
        held: a dict from the path of a placed prim to the coordinates at which its body is held.
    """

    counts: Any
    data: mujoco.MjData
    mounts: Any
    gravity: Floats
    parts: list[Any]
    surfaces: tuple[str, ...]
    handles: dict[tuple[type[Handle[Any]], str], Any]
    held: dict[str, Floats | None]


class SimulationCore(SimulationModel):
    """Steps, resets and copies a simulation. Arguments and errors are those of `SimulationModel`.

    A step is `mj_step2` followed by `mj_step1`: the trajectory equals that of `mj_step` bit by bit, but poses and velocities
    belong to the state after the step, not to the state before it.
    """

    kept = ("_start", "clamped_commands", "dropped_pictures", "seed", "steps", "tick")

    def settle(self) -> None:
        """Let all bodies come to rest; the simulation then starts from this state. Call this before the first step only.

        Raises:
            PhysicsError: the state is no longer finite, or MuJoCo reported an error.
        """
        self.movers.walking = False
        if self.movers:
            self._refresh_movers()
        self.settled_after = settle_bodies(self.model, self.data, self.step)
        self.movers.walking, self.steps = True, 0
        self._refresh_movers()
        self._remember_start()
        self._start_commands()

    def copy(self, seed: int) -> Self:
        """Return an independent copy of this simulation. Call this before the first step only.

        Args:
            seed: seed of the sensor noise in the copy.
        """
        model, rate = copy.copy(self.model), Fraction(*reversed(self.tick_period))
        choices: dict[str, Any] = {"rays": self._rays_choice, "sees_own_robots": self.sees_own_robots}
        made = type(self)(model, self.stage.copy(), rate, self.substeps, seed=seed, **choices)
        mujoco.mj_copyData(made.data, model, self.data)  # which may have settled
        if made.movers:
            made._refresh_movers()  # their random walks depend on the seed
        made.settled_after = self.settled_after
        made._remember_start()
        return made

    def begins_as(self, other: SimulationCore) -> bool:
        """Return whether another simulation has the same prims, model and initial state; neither may have been stepped."""
        return (
            (self.tick_period, self.substeps, self.seed) == (other.tick_period, other.substeps, other.seed)
            and self.stage.is_like(other.stage)
            and np.array_equal(self._start, other._start)
            and model_bytes(self.model) == model_bytes(other.model)
        )

    @property
    def time(self) -> float:
        """Simulation time of this tick, s."""
        return self.tick * self.tick_period[0] / self.tick_period[1]

    @property
    def step_time(self) -> float:
        """Simulation time of the current state, s: that of the last physics step while the steps of a tick run, else `time`."""
        seconds, ticks = self.tick_period
        return self.steps * seconds / (ticks * self.substeps) if self.stepping else self.time

    @property
    def stepping(self) -> bool:
        """Whether the physics steps of a tick are running; graphs that run per physics step are executed at these times."""
        return self.steps > self.tick * self.substeps

    @property
    def in_first_step(self) -> bool:
        """Whether the present physics step is the first one of its tick."""
        return self.steps % self.substeps == 1 % self.substeps

    def _start_commands(self) -> None:
        self.set_points.start()
        self.limits.start()

    def step(self) -> None:
        """Apply joint commands and integrate one substep.

        Raises:
            PhysicsError: the state is no longer finite, or MuJoCo reported an error.
        """
        self._drive_step.prepare(self.substeps - self.steps % self.substeps)
        self.steps += 1
        try:
            mujoco.mj_step2(self.model, self.data)
            for handle in self.handles.feeling:
                handle.see_forces()  # mj_step1 finds the contacts of the state after the step, whose forces are not computed yet
            for body in self.held.values():
                body.hold()
            if self.surfaces:
                self.surfaces.hold()
            if self.steps >= self.movers.due:
                self.movers.follow(self.steps, self.seed)
            mujoco.mj_step1(self.model, self.data)
            if self._directed.geoms:
                self._directed.apply()
        except mujoco.FatalError as error:
            raise gave_up(self.data, error) from error
        if any(self._warnings.tolist()):
            raise diverged(self.model, self.data)
        self.forces.forget()
        if self.pushes:
            self.pushes.advance()
        for handle in self.handles.watching:
            handle.see_motion()

    def begin_tick(self, tick: int) -> None:
        """Set the number of the current tick. The number determines `time`, and the sensors that have a new sample."""
        self.tick = tick
        if self.faults.begin_tick():
            self.handles.advance(self.faults)

    def zero_commands(self) -> None:
        """Set the target velocity and effort of all joints to zero; drives then bring them to rest."""
        self.set_points.zero()

    def reset(self) -> None:
        """Return to the initial state; the same inputs then give the same results bit by bit."""
        self.reset_state()
        self.reset_time()

    def reset_state(self) -> None:
        """Return bodies, joints and commands to their initial state and end all pushes; the tick count continues."""
        self._release_bodies()
        self.pushes.clear()
        self.surfaces.stop()
        if (built := self._mounts.put_back(self.model)) is not None:
            self.continue_with(built)
        self.model.opt.gravity = self._built_gravity
        self._frictions.put_back(self.model)
        self._lights.put_back(self.model)
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, self._start, STATE)
        self._refresh_movers()
        self._start_commands()
        self.forces.forget()
        self.handles.reset()

    def _refresh_movers(self) -> None:
        """Move the movers to their poses at this time, and compute the poses and contacts of all bodies."""
        self.movers.hold(self.steps, self.seed)
        begin_step(self.model, self.data, self._directed)

    def _release_bodies(self) -> None:
        """Release all bodies that handles or welds hold. The model then equals the compiled model."""
        for body in self.held.values():
            body.soften()
        self.held.clear()
        self.welds.clear()

    def reset_time(self) -> None:
        """Set the tick and step counts to zero and discard the sensors' samples; bodies, except movers, keep their state."""
        self.tick = self.steps = 0
        self.faults.clear()
        if self.movers:
            self._refresh_movers()
        self.handles.reset()
        self.dropped_pictures.clear()

    def save(self) -> SavedState:
        """Return a copy of the current state; wait for images that are being rendered."""
        return SavedState(
            super().save(),
            copy.copy(self.data),
            self._mounts.save(),
            self.model.opt.gravity.copy(),
            [part.save() for part in self._parts()],
            tuple(self.surfaces.velocities),
            self.handles.save(),
            {path: body.coordinates for path, body in self.held.items()},
        )

    def restore(self, saved: SavedState) -> None:
        """Restore a state that `save` returned for the same robots. The same inputs then give the same results, bit by bit."""
        self._release_bodies()
        if saved.surfaces != tuple(self.surfaces.velocities):
            assert self.recompile is not None
            model = self.recompile(saved.surfaces)
            self.rebind(model, initial_data(model, self.stage))
        if self._mounts or any(saved.mounts):
            model = self._mounts.put_back(self.model) or copy.copy(self.model)
            self._mounts.restore(saved.mounts)
            self._mounts.carry_over(model)
            self.rebind(model, initial_data(model, self.stage))
        super().restore(saved.counts)
        self.movers.schedule(self.steps, self.seed)
        self.model.opt.gravity = saved.gravity
        self._frictions.put_back(self.model)
        self._lights.put_back(self.model)
        mujoco.mj_copyData(self.data, self.model, saved.data)
        for part, state in zip(self._parts(), saved.parts, strict=True):
            part.restore(state)
        self._frictions.carry_over(self.model)
        self._lights.carry_over(self.model)
        self.handles.restore(saved.handles)
        self.held = {
            path: HeldBody(self.model, self.data, self.stage, self.stage.find(path), coordinates)
            for path, coordinates in saved.held.items()
        }
        self.forces.forget()

    def _parts(self) -> tuple[Stateful, ...]:
        commands, written = (self.set_points, self.limits, self.pushes), (self._frictions, self._lights)
        return *commands, *written, self.surfaces, self.welds, self.faults

    def close(self) -> None:
        """Release all handles."""
        self.handles.clear()
