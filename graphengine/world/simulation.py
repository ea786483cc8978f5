"""One MuJoCo model and its state, behind `backend.World`."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TypeVar

import numpy as np

from graphengine.diagnostics import PhysicsError, PrimError, listing
from graphengine.stage import Prim, PrimKind, Stage
from graphengine.world.drives import Drive, SetPoints, velocity_servo
from graphengine.world.engine import mujoco, sort_geoms
from graphengine.world.handles import CarriedPrim, Handle, Joints
from graphengine.world.sensors.lidar import RayLidar

SETTLED_SPEED = 1e-4
"""m/s and rad/s below which everything counts as at rest."""
SETTLED_FOR = 0.1
"""Seconds that it has to stay so: what begins to fall has no speed at first."""
SETTLE_LIMIT = 5.0
"""Seconds after which a scene starts, at rest or not."""

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
"""What it takes to go on bit by bit: with less, the solver's warm start is missing."""

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
    ) -> None:
        self.stage = stage
        self.tick_period = (tick_rate.denominator, tick_rate.numerator)
        self.substeps = substeps
        self.seed = seed
        self.tick = 0
        self.settled_after: float | None = None
        """Seconds that settling took; None when it was not asked for, or did not come to an end."""
        self.unlimited: list[str] = []
        """Joints whose effort limit is not enforced."""
        self._handles: dict[tuple[type[Handle], str], Handle] = {}
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
        self.unlimited = [name for name, drive in self._drives() if _release(model, name, drive)]
        try:
            mujoco.mj_step1(model, data)
        except mujoco.FatalError as error:
            raise _fatal(data, error) from error
        self.model, self.data = model, data
        self.set_points = SetPoints(data.ctrl, data.qfrc_applied)
        self._control, self._applied = data.ctrl, data.qfrc_applied
        self._warnings = data.warning.number
        self._servos: list[tuple[int, Drive]] = []
        for name, drive in self._drives():
            if drive.damping > 0:
                servo = model.actuator(velocity_servo(name)).id
                self.set_points.changes[servo] = drive.max_acceleration * model.opt.timestep
                self._servos.append((servo, drive))
        self._remember_start()
        for handle in self._handles.values():
            handle.bind()

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

    def _handle(self, kind: type[H], prim: Prim) -> H:
        handle = self._handles.get((kind, prim.path))
        if not isinstance(handle, kind):
            handle = kind(self, prim)
            self._handles[kind, prim.path] = handle
        return handle

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
        try:
            mujoco.mj_step2(self.model, self.data)
            mujoco.mj_step1(self.model, self.data)
        except mujoco.FatalError as error:
            raise _fatal(self.data, error) from error
        if any(self._warnings.tolist()):
            raise PhysicsError(_trouble(self.model, self.data))

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
        self.tick = 0
        for handle in self._handles.values():
            handle.reset()

    def close(self) -> None:
        """Forget the handles."""
        self._handles.clear()

    def _command_start(self) -> None:
        for servo, drive in self._servos:
            self.set_points.targets[servo] = drive.target_velocity
        self.set_points.pending = True

    def _settle(self) -> None:
        step, velocities = self.model.opt.timestep, self.data.qvel
        still = 0
        for count in range(1, round(SETTLE_LIMIT / step) + 1):
            self.step()
            still = still + 1 if np.abs(velocities).max(initial=0.0) < SETTLED_SPEED else 0
            if still * step >= SETTLED_FOR:
                self.settled_after = count * step
                break
        self.data.time = 0.0


def _release(model: mujoco.MjModel, name: str, drive: Drive) -> bool:
    """Take the effort limit off a joint whose drive is too stiff for it.

    A saturated servo is a force that ignores the velocity it causes. Where damping x timestep exceeds the joint's inertia, that
    force overshoots in a single step, and the joint rattles about its target in place of reaching it.
    """
    joint = model.joint(name).id
    inertia = model.dof_M0[model.jnt_dofadr[joint]]
    gain = drive.damping + drive.stiffness * model.opt.timestep
    if not model.jnt_actfrclimited[joint] or gain * model.opt.timestep <= inertia:
        return False
    model.jnt_actfrclimited[joint] = 0
    return True


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
