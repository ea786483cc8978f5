"""Bodies with a surface velocity, such as conveyor belts: they do not move, and carry along the bodies on them.

MuJoCo computes the velocity of a contact only from the joints of both bodies. So a body with a moving surface gets six joints
that have the velocity of the surface. The inertia of these joints is so large that no contact changes their velocity; their
coordinates are reset after each step. (Setting the solver's reference velocity of a contact instead would have no effect: the
discrete integrator overwrites it.)

A box on a belt moves, relative to the belt, like a box that slides on a floor (within 1e-5 m/s), until it has exactly the belt's
speed. Each belt adds 15 us to a step; a model without belts is not slower.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from graphengine.descriptions.engine import Floats, mujoco
from graphengine.devices.rotation import Vector3
from graphengine.format.stateful import Stateful
from graphengine.physics.model.surface_joints import JOINTS, SUFFIX

Velocity = tuple[Vector3, Vector3]
"""Linear (m/s) and angular (rad/s) velocity of a surface about the body's origin, in the body's frame."""

AT_REST: Velocity = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


class MovingSurfaces(Stateful):
    """The moving surfaces of a compiled model; `bound_to` looks them up.

    Attributes:
        velocities: a dict from the name of a body to the velocity of its surface.
    """

    kept = ("velocities",)

    def __init__(self) -> None:
        self.velocities: dict[str, Velocity] = {}
        self._rows: list[tuple[Floats, Floats, str]] = []

    def bound_to(self, model: mujoco.MjModel, data: mujoco.MjData) -> Self:
        """Return the moving surfaces of another model; surfaces that both models have keep their velocities."""
        made, count = type(self)(), len(JOINTS)
        for body in np.flatnonzero(model.body_jntnum == count).tolist():
            name = model.body(body).name
            joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, f"{name}{SUFFIX}0")
            if joint >= 0:
                place, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
                made._rows.append((data.qpos[place : place + count], data.qvel[dof : dof + count], name))
                made.velocities[name] = self.velocities.get(name, AT_REST)
        made.hold()
        return made

    def __bool__(self) -> bool:
        return bool(self._rows)

    def hold(self) -> None:
        """Write the surface velocities to the state, and reset the positions of the surface joints to zero."""
        for coordinates, speeds, body in self._rows:
            coordinates[:] = 0.0
            speeds[:3], speeds[3:] = self.velocities[body]

    def stop(self) -> None:
        """Set all velocities to zero."""
        self.velocities = dict.fromkeys(self.velocities, AT_REST)
