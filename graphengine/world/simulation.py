"""One MuJoCo model and its state, behind `backend.World`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction
from typing import TypeVar

import numpy as np

from graphengine.diagnostics import PhysicsError, PrimError, listing
from graphengine.stage import Prim, PrimKind, Stage
from graphengine.world.common import Common
from graphengine.world.drives import Drive, SetPoints, velocity_servo
from graphengine.world.engine import mujoco, round_weights, sort_geoms
from graphengine.world.force_limits import ForceLimits
from graphengine.world.forces import Forces
from graphengine.world.handles import CarriedPrim, Handle, Joints
from graphengine.world.sensors.camera import PinholeCamera, native_size
from graphengine.world.sensors.contact import BodyContactSensor
from graphengine.world.sensors.imu import InertialUnit
from graphengine.world.sensors.lidar import RayLidar
from graphengine.world.sensors.rays import Rays, RaysChoice
from graphengine.world.sensors.select import select_rays
from graphengine.world.studio import Studio

SETTLED_SPEED = 1e-4
"""m/s and rad/s below which everything counts as at rest."""
SETTLED_FOR = 0.1
"""Seconds that it has to stay so: what begins to fall has no speed at first."""
SETTLE_LIMIT = 5.0
"""Seconds after which a scene starts, at rest or not."""

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""What it takes to go on bit by bit."""

H = TypeVar("H", bound=Handle)


class Simulation:
    """Physics and sensors of a scene.

    A step is `mj_step2`, then `mj_step1`: the trajectory of `mj_step` bit by bit, but poses and velocities belong to the state
    after the step, where `mj_step` leaves those of the state before it.

    Args:
        model: compiled; its timestep is one substep.
        stage: prims whose `body` names bodies of the model.
        tick_rate: ticks a second.
        substeps: physics steps in a tick.
        seed: of the sensors' noise.
        settle: let everything come to rest first; what then is, is the state at the start.
        rays: what lidars see with; `rays.name` tells what `auto` came to.

    Raises:
        PhysicsError: it cannot begin, or diverged while it settled.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        stage: Stage,
        tick_rate: Fraction,
        substeps: int,
        *,
        seed: int = 0,
        settle: bool = False,
        rays: RaysChoice = "auto",
    ) -> None:
        self.stage = stage
        self.tick_period = (tick_rate.denominator, tick_rate.numerator)
        self.substeps = substeps
        self.seed = seed
        self.tick = 0
        self.steps = 0
        """Physics steps since the start."""
        self.settled_after: float | None = None
        """Seconds that settling took; None when it was not asked for, or did not come to an end."""
        self.realtime = False
        """Whether a picture that is late is dropped, in place of being waited for."""
        self.studio = Studio(self)
        self._rays_choice = rays
        self._handles: dict[tuple[type[Handle], str], Handle] = {}
        self._watching: list[Handle] = []
        self.rebind(model, mujoco.MjData(model))
        if settle:
            self._settle()
        self._remember_start()
        self._command_start()

    def rebind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Go on with another model, such as one with a body more; every handle finds its place in it.

        The state that comes with it is what `reset` then goes back to.
        """
        # A diverged state must stay where it can be seen; by default MuJoCo silently begins anew.
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
        sort_geoms(model)
        round_weights(model)
        try:
            mujoco.mj_step1(model, data)
        except mujoco.FatalError as error:
            raise _fatal(data, error) from error
        self.model, self.data = model, data
        self.forces = Forces(model, data)
        self.set_points = SetPoints(data.ctrl, data.qfrc_applied)
        self._control, self._applied = data.ctrl, data.qfrc_applied
        self.limits = ForceLimits(model, data, self._drives())
        self._warnings = data.warning.number
        self._servos: list[tuple[int, Drive]] = []
        for name, drive in self._drives():
            if drive.damping > 0:
                servo = model.actuator(velocity_servo(name)).id
                self.set_points.changes[servo] = drive.max_acceleration * model.opt.timestep
                self._servos.append((servo, drive))
        self._remember_start()
        self._rays: Rays | None = None
        for handle in self._handles.values():
            handle.bind()

    def continue_with(self, model: mujoco.MjModel) -> None:
        """Go on with a model that has a robot more or less; what is in both keeps its state, its commands and its start."""
        before, points, origin = self.data, self.set_points, mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, origin, self._start, _STATE)
        common, data, start = Common(self.model, model), mujoco.MjData(model), mujoco.MjData(model)
        common.carry_over(before, data)
        common.carry_over(origin, start)
        self.rebind(model, data)
        mujoco.mj_getState(model, start, self._start, _STATE)
        self._command_start()
        common.carry_over_commands(points, self.set_points)

    def forget(self, prim_path: str) -> None:
        """Let go of the handles of a prim and of all below it."""
        for key in [key for key in self._handles if f"{key[1]}/".startswith(f"{prim_path}/")]:
            del self._handles[key]
        self._watch()

    def _remember_start(self) -> None:
        self._start = np.empty(mujoco.mj_stateSize(self.model, _STATE))
        mujoco.mj_getState(self.model, self.data, self._start, _STATE)

    def _drives(self) -> Iterator[tuple[str, Drive]]:
        """Joints that have a drive, by their names in the model."""
        for prim in self.stage.prims("joint"):
            robot, drive = self.stage.robot_of(prim), prim.facts["drive"]
            if robot is not None and drive is not None:
                yield f"{robot.name}/{prim.facts['joint']}", drive

    @property
    def time(self) -> float:
        """Simulation time of this tick, s."""
        return self.tick * self.tick_period[0] / self.tick_period[1]

    @property
    def stepping(self) -> bool:
        """Whether a tick's physics steps are under way: who asks now belongs to a graph that runs at each of them."""
        return self.steps > self.tick * self.substeps

    @property
    def rays(self) -> Rays:
        """What the rays of lidars meet in the present model; found when first asked for, as a scene may have no lidar.

        Raises:
            UsageError: `fast` was asked for and cannot be.
        """
        if self._rays is None:
            self._rays = select_rays(self._rays_choice, self.model, self.data)
        return self._rays

    def body(self, prim: Prim) -> CarriedPrim:
        """The rigid body at, or carrying, a prim."""
        return self._handle(CarriedPrim, prim)

    def frame(self, prim: Prim) -> CarriedPrim:
        """The pose of a prim."""
        return self._handle(CarriedPrim, prim)

    def articulation(self, robot: Prim) -> Joints:
        """The joints of a robot prim."""
        self._expect(robot, "robot")
        return self._handle(Joints, robot)

    def lidar(self, prim: Prim) -> RayLidar:
        """The ray-casting sensor at a lidar prim."""
        self._expect(prim, "lidar")
        return self._handle(RayLidar, prim)

    def camera(self, prim: Prim, size: tuple[int, int] | None = None) -> PinholeCamera:
        """The camera at a camera prim, with pictures of a size, or of its own."""
        self._expect(prim, "camera")
        width, height = size or native_size(prim)
        key = (PinholeCamera, f"{prim.path}/{width}x{height}")
        camera = self._handles.get(key)
        if not isinstance(camera, PinholeCamera):
            camera = self._handles[key] = PinholeCamera(self, prim, (width, height))
        return camera

    def imu(self, prim: Prim) -> InertialUnit:
        """The inertial unit at an imu prim."""
        self._expect(prim, "imu")
        return self._handle(InertialUnit, prim)

    def contact_sensor(self, prim: Prim) -> BodyContactSensor:
        """The contact sensor at a contact prim."""
        self._expect(prim, "contact")
        return self._handle(BodyContactSensor, prim)

    def _handle(self, kind: type[H], prim: Prim) -> H:
        handle = self._handles.get((kind, prim.path))
        if not isinstance(handle, kind):
            handle = kind(self, prim)
            self._handles[kind, prim.path] = handle
            self._watch()
        return handle

    def _watch(self) -> None:
        self._watching = [handle for handle in self._handles.values() if handle.sees_steps]

    def _expect(self, prim: Prim, kind: PrimKind) -> None:
        if prim.kind != kind:
            near = [other.path for other in prim.descendants() if other.kind == kind] or [
                other.path for other in self.stage.prims(kind)
            ]
            raise PrimError(f"{prim.path} is a {prim.kind}, not a {kind}", prim.path, listing(near, f"each {kind}"))

    def step(self) -> None:
        """Take over what joints were told and integrate one substep.

        Raises:
            PhysicsError: the state is not finite any more, or MuJoCo could not go on properly.
        """
        if self.set_points.pending:
            self.set_points.take_over(self._control, self._applied)
        if self.limits.joints:
            self.limits.apply(self.set_points.efforts)
        try:
            mujoco.mj_step2(self.model, self.data)
            self.steps += 1
            for handle in self._watching:
                handle.see_forces()  # mj_step1 finds the contacts of the state after the step, whose forces nobody knows yet
            mujoco.mj_step1(self.model, self.data)
        except mujoco.FatalError as error:
            raise _fatal(self.data, error) from error
        if any(self._warnings.tolist()):
            raise PhysicsError(_trouble(self.model, self.data))
        self.forces.forget()
        for handle in self._watching:
            handle.see_motion()

    def begin_tick(self, tick: int) -> None:
        """Tell the sensors that this is tick n, at n times the tick period."""
        self.tick = tick

    def zero_commands(self) -> None:
        """Set the target velocity and effort of every robot's joints to zero; drives bring them there."""
        for servo, _ in self._servos:
            self.set_points.targets[servo] = 0.0
        self.set_points.efforts[:] = 0.0
        self.set_points.pending = True

    def reset(self) -> None:
        """Go back to the state at the start; what follows is the same again, bit by bit."""
        mujoco.mj_resetData(self.model, self.data)
        mujoco.mj_setState(self.model, self.data, self._start, _STATE)
        mujoco.mj_step1(self.model, self.data)
        self.set_points.targets[:] = self._control
        self.set_points.efforts[:] = 0.0
        self._command_start()
        self.forces.forget()
        self.tick = self.steps = 0
        for handle in self._handles.values():
            handle.reset()

    def close(self) -> None:
        """Forget the handles, and end what draws for them."""
        for handle in self._handles.values():
            handle.reset()
        self._handles.clear()
        self.studio.close()

    def _command_start(self) -> None:
        for servo, drive in self._servos:
            self.set_points.targets[servo] = drive.target_velocity
        self.set_points.pending = True

    def _settle(self) -> None:
        """Start each tree of bodies as it was when it came to rest, whatever others still did then."""
        model, data = self.model, self.data
        joints = np.searchsorted(model.jnt_qposadr, np.arange(model.nq), side="right") - 1
        tree_of_position = model.dof_treeid[model.jnt_dofadr[joints]]
        positions, velocities = data.qpos.copy(), data.qvel.copy()
        still, enough = np.zeros(model.ntree, int), math.ceil(SETTLED_FOR / model.opt.timestep)
        for count in range(1, round(SETTLE_LIMIT / model.opt.timestep) + 1):
            self.step()
            speeds = np.zeros(model.ntree)
            np.maximum.at(speeds, model.dof_treeid, np.abs(data.qvel))
            still = np.where(speeds < SETTLED_SPEED, still + 1, 0)
            moving = still <= enough
            np.copyto(positions, data.qpos, where=moving[tree_of_position])
            np.copyto(velocities, data.qvel, where=moving[model.dof_treeid])
            if not moving.any():
                self.settled_after = count * model.opt.timestep
                break
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], self.steps = positions, velocities, 0
        mujoco.mj_step1(model, data)


def _fatal(data: mujoco.MjData, error: Exception) -> PhysicsError:
    """MuJoCo gave up, as over a geometry that it cannot collide."""
    return PhysicsError(f"at t = {data.time:.4f} s MuJoCo gave up: {error}\nlook for degenerate geometry in the scene")


def _trouble(model: mujoco.MjModel, data: mujoco.MjData) -> str:
    """What MuJoCo's counters of warnings say, and what to do about it."""
    kinds, counts = mujoco.mjtWarning, data.warning.number
    at = f"at t = {data.time:.4f} s"
    if counts[kinds.mjWARN_BADCTRL]:
        name = model.actuator(data.warning[kinds.mjWARN_BADCTRL].lastinfo).name.rpartition(".")[0]
        return f"{at}: the command of joint {name!r} is not a finite number"
    if counts[kinds.mjWARN_CONTACTFULL] or counts[kinds.mjWARN_CNSTRFULL]:
        return f'{at}: no memory left for contacts\ngive the world more: <size memory="100M"/>'
    # MuJoCo tells the last coordinate that it found; the fastest is the one to look at.
    joint = int(model.dof_jntid[np.argmax(np.nan_to_num(np.abs(data.qvel), nan=np.inf))])
    body = model.body(model.jnt_bodyid[joint]).name
    return (
        f"the simulation diverged {at}: the motion of joint {model.joint(joint).name!r} of body {body!r} is without bounds\n"
        "raise physics.substeps, lower the drive's damping or stiffness, give it a max_acceleration, "
        "or give the joint an armature"
    )
