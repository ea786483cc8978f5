"""Colliders whose vertices lie in a plane or on a line: what replaces them, and where that is reported."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from graphengine.descriptions.engine import mujoco
from graphengine.descriptions.files.flat_meshes import THICKNESS
from tests.physics.harness import Project

PLATE = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]], [[0, 1, 2], [0, 2, 3]], process=False)
TRIANGLE = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1, 2]], process=False)
LINE = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]], process=False)
BOX = '<collision><geometry><box size=".4 .3 .1"/></geometry></collision>'
MESH = '<{0}>\n      <geometry>\n        <mesh filename="{1}" scale="{2}"/>\n      </geometry></{0}>'


def write(project: Project, mesh: trimesh.Trimesh, name: str, scale: str = "1 1 1", part: str = "collision") -> None:
    """Write a mesh, and a robot whose base has it as its only shape."""
    data: Any = mesh.export(file_type=Path(name).suffix[1:])
    (project.folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
    project.cart(BOX, MESH.format(part, name, scale))


@pytest.mark.parametrize("name", ["plate.stl", "plate.obj", "plate.dae"])
def test_a_flat_collider_becomes_a_plate_of_1_mm_and_is_reported_at_its_element(project: Project, name: str) -> None:
    write(project, PLATE, name, "0.5 -0.1 3")
    loaded, findings = project.load_with_findings()
    model = loaded.simulation.model
    sizes = np.ptp(model.mesh_vert[: model.mesh_vertnum[0]], axis=0)
    assert sorted(sizes) == pytest.approx([THICKNESS, 0.2, 0.5], rel=1e-4)
    told = next(finding for finding in findings.items if "is flat" in finding.message)
    assert told.message == f"the collider {name!r} is flat: a plate of 1 mm replaces it"
    assert str(told.span).endswith("bot.urdf:6:25")


@pytest.mark.parametrize("suffix", ["stl", "obj", "dae"])
def test_a_collider_of_one_triangle_becomes_a_plate(project: Project, suffix: str) -> None:
    write(project, TRIANGLE, f"triangle.{suffix}")
    loaded, findings = project.load_with_findings()
    assert loaded.simulation.model.nmesh == 1
    assert any("is flat" in finding.message for finding in findings.items)


def test_rays_hit_a_plate_from_both_sides(project: Project) -> None:
    write(project, PLATE, "plate.stl")
    project.robot("fixed_base: true")
    simulation = project.load().simulation
    places = {(0.5, 1.0, 0.5): -1.0, (0.5, 1.0, 0.05): 1.0}
    rays = [
        mujoco.mj_ray(simulation.model, simulation.data, at, (0.0, 0.0, up), None, 1, -1, np.zeros(1, np.int32), None)
        for at, up in places.items()
    ]
    assert rays == pytest.approx([0.4 - THICKNESS / 2, 0.05 - THICKNESS / 2], abs=1e-6)


@pytest.mark.parametrize("suffix", ["stl", "obj", "dae"])
def test_a_collider_without_area_is_left_out_and_reported(project: Project, suffix: str) -> None:
    write(project, LINE, f"line.{suffix}")
    loaded, findings = project.load_with_findings()
    assert loaded.simulation.model.nmesh == 0
    assert f"the collider 'line.{suffix}' has no area and is left out" in [each.message for each in findings.items]


@pytest.mark.parametrize("suffix", ["stl", "obj"])
def test_a_visual_of_one_triangle_can_be_seen(project: Project, suffix: str) -> None:
    write(project, TRIANGLE, f"triangle.{suffix}", part="visual")
    assert project.load().simulation.model.nmesh == 1


def test_a_refusal_of_mujoco_is_reported_at_the_element_of_the_description(project: Project) -> None:
    write(project, LINE, "line.stl", part="visual")
    error = project.error()
    assert "bot.urdf:6:9: error S106: MuJoCo: mesh surface area is too small" in error
    assert "'line.stl'" in error
