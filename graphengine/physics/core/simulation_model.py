"""The model of a simulation with its state and the laws that act on it. The model can be exchanged while the simulation runs."""

from __future__ import annotations

from collections.abc import Callable, Collection
from fractions import Fraction

import numpy as np

from graphengine.descriptions.engine import mujoco, round_weights, sort_geoms, wake
from graphengine.devices.rotation import Pose, Quaternion, Vector3
from graphengine.devices.stage import Prim, Stage
from graphengine.format.faults import Faults
from graphengine.format.prim_paths import at_or_below
from graphengine.format.stateful import Stateful
from graphengine.physics.core.handle_table import HandleTable
from graphengine.physics.dynamics.directed_friction import DirectedFriction
from graphengine.physics.dynamics.drive_step import DriveStep
from graphengine.physics.dynamics.force_limits import ForceLimits
from graphengine.physics.dynamics.forces import Forces
from graphengine.physics.dynamics.gravity_compensation import GravityCompensation
from graphengine.physics.dynamics.held_bodies import HeldBody
from graphengine.physics.dynamics.model_overrides import Frictions, Lights
from graphengine.physics.dynamics.mounts import Mounts
from graphengine.physics.dynamics.movers import Movers
from graphengine.physics.dynamics.moving_surfaces import MovingSurfaces
from graphengine.physics.dynamics.pushes import Pushes
from graphengine.physics.dynamics.set_points import SetPoints
from graphengine.physics.dynamics.solver_errors import begin_step, out_of_range
from graphengine.physics.dynamics.start_state import drives_of, initial_data
from graphengine.physics.dynamics.transfer import Transfer
from graphengine.physics.dynamics.welds import Welds
from graphengine.physics.ray_casting.casters import Rays
from graphengine.physics.ray_casting.rays import RaysChoice, select_rays

STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""The part of MuJoCo's state that is needed to continue a simulation bit by bit."""


class SimulationModel(Stateful):
    """A model with its state and clock. `SimulationCore` steps it.

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
        """A dict from the prim path of a camera to the number of its images dropped since play."""
        self.clamps_commands = True
        """Whether a command beyond a joint's limits is clamped; otherwise it is applied unchanged."""
        self.clamped_commands: dict[str, int] = {}
        """Number of clamped commands for each command kind, joint and limit."""
        self._rays_choice = rays
        self.sees_own_robots = sees_own_robots
        self._rays: Rays | None = None
        self.handles = HandleTable(self)
        """Handles by which nodes and sensors use prims; all are bound to the current model."""
        self._mounts = Mounts()
        self._frictions = Frictions(stage)
        self._lights = Lights(stage)
        self.faults = Faults()
        """Faults of sensors; the keys are prim paths."""
        self.pushes = Pushes()
        self.surfaces = MovingSurfaces()
        self.movers = Movers(self.tick_period, substeps)
        self.welds = Welds()
        self.recompile: Callable[[Collection[str]], mujoco.MjModel] | None = None
        """Function that recompiles the model with moving surfaces on the named bodies; `LoadedWorld` sets it."""
        self.held: dict[str, HeldBody] = {}
        """A dict from the path of a placed prim to its body, which is held at its pose."""
        self._built_gravity = model.opt.gravity.copy()
        self.rebind(model, initial_data(model, stage))

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
        movers = self.movers.bound_to(model, data)
        movers.hold(self.steps, self.seed)
        begin_step(model, data, directed := DirectedFriction(self.stage, model, data))
        if data.warning[mujoco.mjtWarning.mjWARN_BADQPOS].number:
            raise out_of_range(model, data)
        self._rays = select_rays(self._rays_choice, model, data) if self._rays is not None else None
        self.model, self.data, self._directed, self.surfaces, self.welds = model, data, directed, surfaces, welds
        self.movers = movers
        self.forces = Forces(model, data)
        drives = list(drives_of(self.stage))
        self.set_points = SetPoints(model, data, drives)
        self.limits = ForceLimits(model, data, drives)
        compensation = GravityCompensation(model, data, drives)
        self._drive_step = DriveStep(model, data, self.set_points, self.limits, compensation)
        # A model that is close to singular from the start was told to be, when it was built; most of them do move.
        singular = bool(data.warning[mujoco.mjtWarning.mjWARN_INERTIA].number)
        self._warnings = data.warning.number[mujoco.mjtWarning.mjWARN_INERTIA + singular :]
        self._remember_start()
        self.pushes.bind(model, data)
        self.handles.bind()
        for body in self.held.values():
            body.bind(model, data)
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
        transfer = Transfer(self.model, model)
        data, start = initial_data(model, self.stage), initial_data(model, self.stage)
        transfer.carry_over(before, data)
        if awake:
            wake(model, data)
        transfer.carry_over(origin, start)
        self.rebind(model, data)
        mujoco.mj_getState(model, start, self._start, STATE)
        transfer.carry_over_commands(points, self.set_points)
        self.limits.carry_over(limits)

    def with_mount(self, body: int, pose: Pose) -> mujoco.MjModel:
        """Return a copy of the model in which a body that is fixed to the world is at a pose in the world frame."""
        return self._mounts.moved(self.model, body, pose)[1]

    def is_moved(self, body: int) -> bool:
        """Return whether a body that is fixed to the world was moved by `move_mount`."""
        return self.model.body(body).name in self._mounts

    def move_mount(self, body: int, pose: Pose) -> None:
        """Move a body that is fixed to the world to a pose in the world frame.

        Raises:
            PhysicsError: MuJoCo cannot compute the contacts of the moved body; nothing has changed.
        """
        for held in self.held.values():
            held.soften()  # what is copied is to be as it was built
        self.welds.withdraw()
        before = self._mounts
        self._mounts, model = before.moved(self.model, body, pose)
        try:
            self.continue_with(model, awake=True)
        except BaseException:
            self._mounts = before
            for held in self.held.values():
                held.bind(self.model, self.data)
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

    def place(self, prim: Prim, position: Vector3, orientation: Quaternion) -> None:
        """Place a prim at rest and hold its body at this pose; all handles then return the new pose.

        Args:
            prim: prim for which `find_mover` finds a body.
            position: position in the world frame, m.
            orientation: unit quaternion (x, y, z, w) in the world frame.

        Raises:
            PhysicsError: a number is outside MuJoCo's range; nothing has changed.
        """
        body = self.held.get(prim.path) or HeldBody(self.model, self.data, self.stage, prim)
        body.aim(position, orientation)
        if prim.path not in self.held:
            self.let_go(body.body)  # another prim may have put it elsewhere
            self.held[prim.path] = body
            body.make_firm()
        body.hold()
        self.refresh()

    def let_go(self, body: int) -> None:
        """Stop holding a placed body; physics then moves it again."""
        for path in [path for path, held in self.held.items() if held.body == body]:
            self.held.pop(path).soften()

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

    def wake_all(self) -> None:
        """Wake all sleeping bodies and update derived quantities; call this when the forces on bodies have changed."""
        wake(self.model, self.data)
        self.refresh()

    def initial_state(self) -> mujoco.MjData:
        """Return a copy of the state that `reset_state` restores."""
        data = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, data, self._start, STATE)
        return data

    def _remember_start(self) -> None:
        self._start = np.empty(mujoco.mj_stateSize(self.model, STATE))
        mujoco.mj_getState(self.model, self.data, self._start, STATE)

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
        self.held = {path: body for path, body in self.held.items() if not at_or_below(path, prim_path)}
        self.handles.forget(prim_path)
