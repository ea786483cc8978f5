"""The core of a simulation, which handles and sensors use: its model, state and clock, steps, resets and checkpoints."""

from __future__ import annotations

import copy
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Self

import numpy as np

from graphengine.descriptions.actuators.drives import Drive
from graphengine.descriptions.engine import Floats, data_at_start, model_bytes, mujoco, round_weights, sort_geoms, wake
from graphengine.devices.rotation import Pose
from graphengine.devices.stage import Stage
from graphengine.format.prim_paths import at_or_below
from graphengine.format.stateful import Stateful
from graphengine.physics.core.handle_table import Handle, HandleTable
from graphengine.physics.core.held_bodies import PlacedBody
from graphengine.physics.dynamics.directed_friction import DirectedFriction
from graphengine.physics.dynamics.drive_step import DriveStep
from graphengine.physics.dynamics.force_limits import ForceLimits
from graphengine.physics.dynamics.forces import Forces
from graphengine.physics.dynamics.gravity_compensation import GravityCompensation
from graphengine.physics.dynamics.keyframes import start_robot
from graphengine.physics.dynamics.model_overrides import Frictions, Lights
from graphengine.physics.dynamics.mounts import Mounts
from graphengine.physics.dynamics.moving_surfaces import MovingSurfaces
from graphengine.physics.dynamics.pushes import Pushes
from graphengine.physics.dynamics.set_points import SetPoints
from graphengine.physics.dynamics.settling import settle as settle_bodies
from graphengine.physics.dynamics.solver_errors import begin_step, diverged, gave_up, out_of_range
from graphengine.physics.dynamics.transfer import Transfer
from graphengine.physics.dynamics.welds import Welds
from graphengine.physics.ray_casting.rays import Rays, RaysChoice, select_rays

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION  # what it takes to go on bit by bit


@dataclass(frozen=True, slots=True)
class SavedState:
    """The state of a simulation in a checkpoint.

    Attributes:
        counts: the attributes that `SimulationCore.kept` names: seed, start state, and numbers of ticks, steps and other events.
        data: MuJoCo's state.
        mounts: poses of the bodies that are fixed to the world and were moved.
        gravity: acceleration of free fall in the world frame, m/s2.
        parts: states of set points, force limits, pushes, written frictions, written lights, moving surfaces and welds.
        surfaces: names of the bodies that have moving surfaces.
        handles: states of the handles (such as sensor samples), by handle class and key.
        held: paths of the prims that a node placed and that are held at their poses.
    """

    counts: Any
    data: mujoco.MjData
    mounts: Any
    gravity: Floats
    parts: list[Any]
    surfaces: tuple[str, ...]
    handles: dict[tuple[type[Handle], str], Any]
    held: list[str]


class SimulationCore(Stateful):
    """A model with its state and clock.

    A step is `mj_step2` followed by `mj_step1`: the trajectory equals that of `mj_step` bit by bit, but poses and velocities
    belong to the state after the step, not to the state before it.

    Args:
        model: compiled model; its timestep is one substep.
        stage: prims whose `body` names bodies of the model.
        tick_rate: ticks per second.
        substeps: physics steps in a tick.
        seed: seed of the sensors' noise.
        rays: method of casting the rays of lidars; for `auto`, `rays_in_use` names the method that was selected.
        sees_own_robots: whether sensors whose robot file does not say so see their own robot.

    Raises:
        PhysicsError: the simulation cannot start, or diverged while settling.
    """

    kept = ("_start", "clamped_commands", "dropped_pictures", "seed", "steps", "tick")

    def __init__(
        self,
        model: mujoco.MjModel,
        stage: Stage,
        tick_rate: Fraction,
        substeps: int,
        *,
        seed: int = 0,
        rays: RaysChoice = "auto",
        sees_own_robots: bool = True,
    ) -> None:
        self.stage = stage
        self.tick_period = (tick_rate.denominator, tick_rate.numerator)
        self.substeps = substeps
        self.seed = seed
        """Seed of the sensors' noise; a new value takes effect with the next sample."""
        self.tick = 0
        self.steps = 0
        """Number of physics steps since the start."""
        self.settled_after: float | None = None
        """Simulation time that settling took, s; None if it was not requested or not all bodies came to rest."""
        self.realtime = False
        """Whether late camera images are dropped; if False, the tick in which an image is due waits for it."""
        self.dropped_pictures: dict[str, int] = {}
        """Number of images dropped since play, by prim path of the camera."""
        self.clamps_commands = True
        """Whether a command beyond a joint's limits is clamped; otherwise it is applied unchanged."""
        self.clamped_commands: dict[str, int] = {}
        """Number of commands that were clamped, by kind, joint and limit."""
        self._rays_choice = rays
        self.sees_own_robots = sees_own_robots
        self._rays: Rays | None = None
        self.handles = HandleTable(self)
        """Handles by which nodes and sensors use prims; all are bound to the current model."""
        self._mounts = Mounts()
        self._frictions = Frictions(stage)
        self._lights = Lights(stage)
        self.pushes = Pushes()
        self.surfaces = MovingSurfaces()
        self.welds = Welds()
        self.recompile: Callable[[Collection[str]], mujoco.MjModel] | None = None
        """Function that recompiles the model with moving surfaces on the named bodies; `LoadedWorld` sets it."""
        self.held: list[PlacedBody] = []
        """Handles of the bodies that were placed and are held at their poses."""
        self._built_gravity = model.opt.gravity.copy()
        self.rebind(model, self._data_at_start(model))

    def settle(self) -> None:
        """Let all bodies come to rest; the simulation then starts from this state. Call this before the first step only.

        Raises:
            PhysicsError: the state is no longer finite, or MuJoCo reported an error.
        """
        self.settled_after = settle_bodies(self.model, self.data, self.step)
        begin_step(self.model, self.data, self._directed)
        self.steps = 0
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

    def rebind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Switch to another model and state, for example with an additional body, and bind all handles to them.

        `reset` then returns to this state. After an error, nothing has changed.

        Raises:
            PhysicsError: MuJoCo cannot compute poses and contacts of the state.
            UsageError: the requested ray casting method cannot be used with the model.
        """
        # A diverged state must stay where it can be seen; by default MuJoCo silently begins anew.
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        sort_geoms(model)
        round_weights(model)
        surfaces, welds = self.surfaces.bound_to(model, data), self.welds.bound_to(model, data)
        begin_step(model, data, directed := DirectedFriction(self.stage, model, data))
        if data.warning[mujoco.mjtWarning.mjWARN_BADQPOS].number:
            raise out_of_range(model, data)
        self._rays = select_rays(self._rays_choice, model, data) if self._rays is not None else None
        self.model, self.data, self._directed, self.surfaces, self.welds = model, data, directed, surfaces, welds
        self.forces = Forces(model, data)
        drives = list(self.drives())
        self.set_points = SetPoints(model, data, drives)
        self.limits = ForceLimits(model, data, drives)
        self._drive_step = DriveStep(
            model, data, self.set_points, self.limits, GravityCompensation(model, data, drives)
        )
        # A model that is close to singular from the start was told to be, when it was built; most of them do move.
        singular = bool(data.warning[mujoco.mjtWarning.mjWARN_INERTIA].number)
        self._warnings = data.warning.number[mujoco.mjtWarning.mjWARN_INERTIA + singular :]
        self._remember_start()
        self.pushes.bind(model, data)
        self.handles.bind()
        if self.held:
            self.refresh()

    def continue_with(self, model: mujoco.MjModel, *, awake: bool = False) -> None:
        """Switch to a changed model, for example to add or remove a robot.

        Bodies that both models have keep their state, commands and initial pose.

        Args:
            model: compiled model.
            awake: whether to wake all sleeping bodies, because their support may have moved.
        """
        self._mounts.carry_over(model)
        self._frictions.carry_over(model)
        self._lights.carry_over(model)
        model.opt.gravity = self.model.opt.gravity
        before, origin, points, limits = self.data, self.initial_state(), self.set_points, self.limits
        transfer, data, start = Transfer(self.model, model), self._data_at_start(model), self._data_at_start(model)
        transfer.carry_over(before, data)
        if awake:
            wake(model, data)
        transfer.carry_over(origin, start)
        self.rebind(model, data)
        mujoco.mj_getState(model, start, self._start, _STATE)
        transfer.carry_over_commands(points, self.set_points)
        self.limits.carry_over(limits)

    def with_mount(self, body: int, pose: Pose) -> mujoco.MjModel:
        """Return a copy of the model in which a body that is fixed to the world is at a pose in the world frame."""
        return self._mounts.moved(self.model, body, pose)[1]

    def move_mount(self, body: int, pose: Pose) -> None:
        """Move a body that is fixed to the world to a pose in the world frame.

        Raises:
            PhysicsError: MuJoCo cannot compute the contacts of the moved body; nothing has changed.
        """
        for held in self.held:
            held.soften()  # what is copied is to be as it was built
        self.welds.withdraw()
        before = self._mounts
        self._mounts, model = before.moved(self.model, body, pose)
        try:
            self.continue_with(model, awake=True)
        except BaseException:
            self._mounts = before
            for held in self.held:
                held.bind()
            self.welds = self.welds.bound_to(self.model, self.data)
            raise
        for handle in self.handles.watching:
            handle.see_displacement()

    def add_surfaces(self, bodies: Collection[str]) -> None:
        """Add a moving surface, initially at rest, to the named bodies.

        Raises:
            CheckError: MuJoCo refuses the model; the simulation is unchanged.
        """
        assert self.recompile is not None  # a world that was loaded sets it
        self.continue_with(self.recompile([*self.surfaces.velocities, *bodies]))

    def let_go(self, body: int) -> None:
        """Stop holding a placed body, so that physics moves it again."""
        for held in [held for held in self.held if held.body == body]:
            held.release()
            self.held.remove(held)

    def refresh(self) -> None:
        """Update derived quantities after the state was written directly.

        Raises:
            PhysicsError: MuJoCo cannot compute poses and contacts of this state.
        """
        begin_step(self.model, self.data, self._directed)
        self.forces.forget()
        self.pushes.apply()
        for handle in self.handles.watching:
            handle.see_displacement()

    def _data_at_start(self, model: mujoco.MjModel) -> mujoco.MjData:
        """Return the initial state of a model: robots in keyframes, joints at their start positions and held there."""
        data = data_at_start(model)
        for robot in self.stage.prims("robot"):
            joints = [prim.facts for prim in robot.descendants() if prim.kind == "joint"]
            starts = {facts["joint"]: facts["start"] for facts in joints if "start" in facts}
            start_robot(robot, model, data, starts, robot.facts.get("keyframe"))
        return data

    def initial_state(self) -> mujoco.MjData:
        """Return the state to which `reset_state` returns, as a new object."""
        data = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, data, self._start, _STATE)
        return data

    def _remember_start(self) -> None:
        self._start = np.empty(mujoco.mj_stateSize(self.model, _STATE))
        mujoco.mj_getState(self.model, self.data, self._start, _STATE)

    def _start_commands(self) -> None:
        self.set_points.start()
        self.limits.start()

    def drives(self) -> Iterator[tuple[str, Drive]]:
        """Yield pairs of a joint's name in the model and the joint's drive.

        Drives that do not move exactly one joint come last, with their robot's prefix in place of a joint name.
        """
        for prim in self.stage.prims("joint"):
            robot, drive = self.stage.robot_of(prim), prim.facts["drive"]
            if robot is not None and drive is not None:
                yield f"{robot.entity_name}/{prim.facts['joint']}", drive
        for robot in self.stage.prims("robot"):
            for drive in robot.facts.get("other_actuators", {}).values():
                yield f"{robot.entity_name}/", drive

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

    def step(self) -> None:
        """Apply joint commands and integrate one substep.

        Raises:
            PhysicsError: the state is no longer finite, or MuJoCo reported an error.
        """
        self._drive_step.prepare(self.substeps - self.steps % self.substeps)
        self.steps += 1
        try:
            mujoco.mj_step2(self.model, self.data)
            for handle in self.handles.watching:
                handle.see_forces()  # mj_step1 finds the contacts of the state after the step, whose forces nobody knows yet
            for body in self.held:
                body.hold()
            if self.surfaces:
                self.surfaces.hold()
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
        """Set the number of the current tick, which determines `time` and which sensors have a new sample."""
        self.tick = tick

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
        mujoco.mj_setState(self.model, self.data, self._start, _STATE)
        begin_step(self.model, self.data, self._directed)
        self._start_commands()
        self.forces.forget()
        self.handles.reset()

    def _release_bodies(self) -> None:
        """Release all bodies that handles or welds hold, so that the model is as it was compiled."""
        for body in self.held:
            body.release()
        self.held.clear()
        self.welds.clear()

    def reset_time(self) -> None:
        """Set the tick and step counts to zero and discard the sensors' samples; bodies and joints keep their state."""
        self.tick = self.steps = 0
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
            [body.prim_path for body in self.held],
        )

    def restore(self, saved: SavedState) -> None:
        """Restore a state that `save` returned for the same robots. The same inputs then give the same results, bit by bit."""
        self._release_bodies()
        if saved.surfaces != tuple(self.surfaces.velocities):
            assert self.recompile is not None
            model = self.recompile(saved.surfaces)
            self.rebind(model, self._data_at_start(model))
        if self._mounts or any(saved.mounts):
            model = self._mounts.put_back(self.model) or copy.copy(self.model)
            self._mounts.restore(saved.mounts)
            self._mounts.carry_over(model)
            self.rebind(model, self._data_at_start(model))
        super().restore(saved.counts)
        self.model.opt.gravity = saved.gravity
        self._frictions.put_back(self.model)
        self._lights.put_back(self.model)
        mujoco.mj_copyData(self.data, self.model, saved.data)
        for part, state in zip(self._parts(), saved.parts, strict=True):
            part.restore(state)
        self._frictions.carry_over(self.model)
        self._lights.carry_over(self.model)
        self.handles.restore(saved.handles)
        self.held = [self.handles.find(PlacedBody, self.stage.find(path)) for path in saved.held]
        for body in self.held:
            body.bind()
        self.forces.forget()

    def _parts(self) -> tuple[Stateful, ...]:
        return self.set_points, self.limits, self.pushes, self._frictions, self._lights, self.surfaces, self.welds

    def close(self) -> None:
        """Release all handles."""
        self.handles.clear()

    @property
    def rays(self) -> Rays:
        """The ray caster of lidars for the current model; it is created at first use, because a scene may have no lidar.

        Raises:
            UsageError: `fast` was requested but cannot be used.
        """
        if self._rays is None:
            self._rays = select_rays(self._rays_choice, self.model, self.data)
        return self._rays

    @property
    def rays_in_use(self) -> str:
        """Name of the ray casting method that is used; empty until a lidar is used."""
        return self._rays.name if self._rays is not None else ""

    def forget(self, prim_path: str) -> None:
        """Release the handles of a prim and of all prims below it."""
        self.held = [body for body in self.held if not at_or_below(body.prim_path, prim_path)]
        self.handles.forget(prim_path)
