"""Handles to poses and velocities of prims, handles that place prims, and handles to the joints of a robot.

A handle keeps ids, and views into MuJoCo's arrays. Both are valid for one model only; after the model was recompiled, `bind`
looks them up again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from graphengine.descriptions.actuators.drives import KINDS, Drive, Servo, servo_ids
from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.backend import select_joints
from graphengine.devices.motion import CommandKind, JointFacts
from graphengine.devices.rotation import NOWHERE, Quaternion, Vector3, multiply, rotate
from graphengine.format.errors import BadValueError
from graphengine.format.stateful import Shared
from graphengine.physics.core.handle_table import Handle
from graphengine.physics.dynamics.command_limits import add_limits, command_limits

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore

ROUNDING = 1e-6
"""Largest excess of a command over its limit that is clamped without being counted, relative to limits above 1; rounding in
trajectories and in parameters of graphs causes less."""


class CoreHandle(Handle["SimulationCore"]):
    """Base class of handles that need no more than a `SimulationCore`."""


class CarriedPrim(CoreHandle):
    """A prim that moves with the body that carries it; without such a body, the prim is static."""

    def bind(self) -> None:
        """Look up the body that carries the prim, and the pose of the prim in the body's frame."""
        model, data = self._simulation.model, self._simulation.data
        name, pose = self._prim.carrier()
        self.body = body = model.body(name).id if name is not None else 0
        self._offset = pose if pose != NOWHERE else None
        self._position, self._rotation = data.xpos[body], data.xquat[body]
        # Velocities come about the centre of mass of the body's whole tree.
        self._twist, self._centre = data.cvel[body], data.subtree_com[model.body_rootid[body]]

    def pose(self) -> tuple[Vector3, Quaternion]:
        """Return position (m) and orientation (x, y, z, w) in the world frame."""
        x, y, z = self._position.tolist()
        d, a, b, c = self._rotation.tolist()
        if self._offset is None:
            return (x, y, z), (a, b, c, d)
        offset, turn = self._offset
        u, v, w = rotate((a, b, c, d), offset)
        return (x + u, y + v, z + w), multiply((a, b, c, d), turn)

    def frame(self) -> tuple[Floats, Floats]:
        """Return position (m) and rotation matrix in the world frame as new arrays, of shapes (3,) and (3, 3)."""
        position, (x, y, z, w) = self.pose()
        rotation = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
        return np.array(position), np.array(rotation)

    def velocity(self) -> tuple[Vector3, Vector3]:
        """Return linear (m/s) and angular (rad/s) velocity of the prim's origin in the world frame."""
        a, b, c, u, v, w = self._twist.tolist()
        x, y, z = self._position.tolist()
        if self._offset is not None:
            d, e, f, g = self._rotation.tolist()
            i, j, k = rotate((e, f, g, d), self._offset[0])
            x, y, z = x + i, y + j, z + k
        p, q, r = self._centre.tolist()
        x, y, z = x - p, y - q, z - r
        return (u + b * z - c * y, v + c * x - a * z, w + a * y - b * x), (a, b, c)


class PlacedBody(CoreHandle):
    """A handle that places a prim at a pose, and holds its body there until the simulation is reset."""

    def bind(self) -> None:
        """Do nothing: the simulation itself looks up the bodies that it holds."""

    def place(self, position: Vector3, orientation: Quaternion) -> None:
        """Place the prim at rest and hold its body at this pose; see `SimulationCore.place`."""
        self._simulation.place(self._prim, position, orientation)


class Joints(CoreHandle, JointFacts):
    """A handle to the moving joints of a robot."""

    kept = ("resets",)

    def _set_up(self) -> None:
        JointFacts.__init__(self, self._prim)
        self.resets = 0
        """Number of resets of the simulation or of the robot so far."""

    def reset(self) -> None:
        """Count a reset of the simulation or of the robot in `resets`."""
        self.resets += 1

    def bind(self) -> None:
        """Look up the joints and the servos of their drives."""
        model, data = self._simulation.model, self._simulation.data
        robot = self._prim
        drives: dict[str, Drive | None] = {
            prim.facts["joint"]: prim.facts["drive"] for prim in robot.descendants() if prim.kind == "joint"
        }
        own = [drives[name] or Drive() for name in self.joint_names]
        joints = [f"{robot.entity_name}/{name}" for name in self.joint_names]
        others: Mapping[str, Drive] = robot.facts.get("other_actuators", {})
        ids = np.array([model.joint(joint).id for joint in joints], np.intp)
        self._data = data
        self._control = data.ctrl if model.nu else np.zeros(1)
        # As numpy indexes: with the int32 of MuJoCo it takes four times as long.
        self._qpos, self.dofs = model.jnt_qposadr[ids].astype(np.intp), model.jnt_dofadr[ids].astype(np.intp)
        self._children = model.jnt_bodyid[ids]
        self._trees = model.body_rootid[self._children]
        gains = [(d.stiffness, d.damping) if d.servos is None else (0.0, 0.0) for d in own]
        self.stiffness, self._damping = np.array(gains, float).reshape(-1, 2).T
        self.limits = command_limits(model, robot, ids.tolist())
        for drive in others.values():
            add_limits(self.limits, drive)
        self.target_ranges = tuple(self.limits["position"][: len(joints)])
        """Lowest and highest position target of each joint, rad or m."""
        self._has_springs = bool(self.stiffness.any())
        self._has_actuators = any(drive.servos is not None for drive in own)
        commanded = [*zip(joints, own, strict=True), *((f"{robot.entity_name}/", drive) for drive in others.values())]
        self.servos = [[drive.servo(name, kind) for kind in KINDS] for name, drive in commanded]
        self.servo_ids = servo_ids(model, commanded)
        self.position_servos, self.velocity_servos, _ = self.servo_ids[:, : len(joints)]

    def select(self, names: Sequence[str] = (), indices: Sequence[int] = ()) -> SelectedJoints:
        """Return the joints selected by joint or actuator names, otherwise by indices, otherwise all joints.

        Raises:
            JointError: the robot does not have a given name or index.
        """
        return SelectedJoints(self._simulation, self, select_joints(self, names, indices))

    def positions(self) -> Floats:
        """Return the joint positions, rad or m, as a new array."""
        positions: Floats = self._data.qpos[self._qpos]
        return positions

    def velocities(self) -> Floats:
        """Return the joint velocities, rad/s or m/s, as a new array."""
        velocities: Floats = self._data.qvel[self.dofs]
        return velocities

    def set_points(self) -> tuple[Floats, Floats]:
        """Return the position and velocity target of each joint's drive as two new arrays, with NaN for missing targets."""
        targets = np.append(self._simulation.set_points.targets, np.nan)  # the last is what servo -1 has
        positions, velocities = targets[self.position_servos], targets[self.velocity_servos]
        if self._has_actuators:
            for joint in range(len(self.joint_names)):
                positions[joint] = _command(self.servos[joint][0], positions[joint])
                velocities[joint] = _command(self.servos[joint][1], velocities[joint])
        return positions, velocities

    def efforts(self) -> Floats:
        """Return each joint's effort at the end of the last step, N m or N, as a new array.

        The effort is the sum of the drive's effort and the commanded effort. MuJoCo's own `actuator_force` is computed from the
        velocity before the step: with the discrete integrator, it can be 15 times the torque that accelerates a robot.
        """
        if self._has_actuators:
            driven = self._simulation.forces.now().qfrc_actuator[self.dofs]
            own = driven - self._damping * self.velocities() - self.stiffness * self.positions()
            measured: Floats = own + self._data.qfrc_applied[self.dofs]
            return measured
        force = self._damping * (self._control[self.velocity_servos] - self.velocities())
        if self._has_springs:
            force += self.stiffness * (self._control[self.position_servos] - self.positions())
        efforts: Floats = force + self._data.qfrc_applied[self.dofs]
        return efforts

    def wrenches(self) -> tuple[Floats, Floats]:
        """Return the forces (N) and torques (N m) that each joint's parent link exerts on its child link.

        Both are new arrays of shape (joints, 3), in the child link's frame; torques are about the child link's origin. MuJoCo's
        values have the world's axes, and torques about the centre of mass of the robot's whole tree; they are converted.
        """
        data = self._simulation.forces.now()
        torques, forces = np.hsplit(data.cfrc_int[self._children], 2)
        torques = torques + np.cross(data.subtree_com[self._trees] - data.xpos[self._children], forces)
        axes = data.xmat[self._children].reshape(-1, 3, 3)
        return np.einsum("jik,ji->jk", axes, forces), np.einsum("jik,ji->jk", axes, torques)


def _command(servo: Servo | None, control: float) -> float:
    """Return the command for which an actuator gets a control signal; the signal itself if there is no conversion."""
    return control if servo is None or servo.scale == 0.0 else (control - servo.offset) / servo.scale


class SelectedJoints(Shared):
    """Selected joints of a robot, in the requested order."""

    __slots__ = ("_chosen", "_joints", "_simulation", "names")

    def __init__(self, simulation: SimulationCore, joints: Joints, chosen: Sequence[int]) -> None:
        self._simulation = simulation
        self._joints = joints
        self._chosen = tuple(chosen)
        self.names = tuple(joints.commanded_names[index] for index in chosen)

    def command(
        self,
        positions: Sequence[float] | None = None,
        velocities: Sequence[float] | None = None,
        efforts: Sequence[float] | None = None,
    ) -> None:
        """Set joint targets. They take effect in the next physics step.

        Like PhysX, this method ignores a target that the drive does not use: a velocity without damping, a position without
        stiffness. A command beyond the joint's limits is clamped and counted, unless the simulation's `clamps_commands` is false.
        With a clamped position, the velocity target of the joint is 0, because the joint stops there.

        Args:
            positions: target of each selected joint, rad or m. NaN keeps the target of that joint, None keeps all.
            velocities: the same for velocity targets, rad/s or m/s.
            efforts: the same for commanded efforts, N m or N.

        Raises:
            BadValueError: a number is outside MuJoCo's range; nothing was set.
        """
        points, joints = self._simulation.set_points, self._joints
        found: list[tuple[Floats, int, float]] = []
        stopped: set[int] = set()
        commands = zip(KINDS, (positions, velocities, efforts), joints.servo_ids, strict=True)
        for number, (kind, values, places) in enumerate(commands):
            if values is None:
                continue
            for joint, value in zip(self._chosen, values, strict=True):
                if abs(value) > mujoco.mjMAXVAL:
                    name = joints.commanded_names[joint]
                    raise BadValueError(f"{kind}Command", values, f"up to {mujoco.mjMAXVAL:g} for joint {name!r}")
                if value != value:
                    continue
                servo = joints.servos[joint][number]
                if servo is not None:
                    command = self._clamped(kind, joint, 0.0 if joint in stopped else value)
                    if kind == "position" and command != value:
                        stopped.add(joint)
                    found.append((points.targets, places[joint], servo.control(command)))
                elif kind == "effort" and joint < len(joints.dofs):
                    found.append((points.efforts, joints.dofs[joint], self._clamped(kind, joint, value)))
        for array, place, value in found:
            if array[place] != value:
                array[place], points.pending = value, True

    def undriven(self, kind: CommandKind) -> list[str]:
        """Return the names of the selected joints on which commands of this kind have no effect; every joint takes efforts."""
        joints, number = self._joints, KINDS.index(kind)
        free = len(joints.dofs) if kind == "effort" else 0
        without = [joint for joint in self._chosen if joint >= free and joints.servos[joint][number] is None]
        return [joints.commanded_names[joint] for joint in without]

    def _clamped(self, kind: CommandKind, joint: int, value: float) -> float:
        """Return a command clamped to its joint's limits, and count the clamping; unchanged if the simulation does not clamp."""
        lowest, highest = self._joints.limits[kind][joint]
        if lowest <= value <= highest or not self._simulation.clamps_commands:
            return value
        clamped = min(max(value, lowest), highest)
        if abs(clamped - value) <= ROUNDING * max(1.0, abs(clamped)):
            return clamped
        counts = self._simulation.clamped_commands
        name = f"{self._joints.prim_path}/{self._joints.commanded_names[joint]}"
        what = f"{kind} of {name} beyond {lowest:g} to {highest:g}"
        counts[what] = counts.get(what, 0) + 1
        return clamped
