"""Warns about meshes of robots that are probably in millimetres, or scaled from millimetres though they are in metres."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.shapes import Mesh
from graphengine.format.diagnostics import Findings
from graphengine.physics.model.robot import RobotInstance

LARGEST = 20.0
"""Size of a mesh above which it is probably in millimetres, m."""
SMALLEST = 0.0005
"""Size of a mesh with the scale of millimetres below which it is probably in metres, m."""
_MILLI = (0.001, 0.001, 0.001)


def check_mesh_units(model: mujoco.MjModel, robots: Iterable[tuple[str, RobotInstance]], findings: Findings) -> None:
    """Warn once about each mesh with an improbable size.

    Args:
        model: compiled model that contains the robots.
        robots: prefix of the names of a robot in the model, and the robot; robots of one kind share their description.
        findings: receives the warnings.
    """
    told: set[str] = set()
    for prefix, robot in robots:
        for name, mesh in _meshes(robot):
            geom = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, f"{prefix}{name}")
            if geom < 0 or (place := str(mesh.element.span)) in told:
                continue
            size = 2.0 * float(model.geom_aabb[geom, 3:].max())
            if size > LARGEST and mesh.scale == (1.0, 1.0, 1.0):
                remedy = 'if it is in millimetres, write scale="0.001 0.001 0.001"'
            elif size < SMALLEST and mesh.scale == _MILLI:
                remedy = "if it is in metres, remove the scale"
            else:
                continue
            told.add(place)
            text = f"the mesh {mesh.filename!r} is {size:.3g} m long"
            findings.add("W217", text, mesh.element.place("filename"), remedy)


def _meshes(robot: RobotInstance) -> Iterator[tuple[str, Mesh]]:
    """Yield the name of the geom and the mesh of each shape of a robot that a URDF or SDF file describes."""
    for link in robot.description.links.values() if robot.description.mjcf is None else ():
        for shape in link.shapes:
            if isinstance(shape.geometry, Mesh):
                yield f"{shape.name}.0", shape.geometry
