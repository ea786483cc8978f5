"""A robot behaves as a stage as it does as a URDF: it drives, turns and swings within 1 % of it."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("pxr")

import graphengine as ge
from tests.descriptions.usd.stages import WHEELS, arm, rover

WORLD = "scene: s\nworld: worlds/flat_grid.xml\nrobots:\n  bot: {{use: {}, position: [0, 0, {}]}}\n"


def inertial(mass: float, xx: float, yy: float, zz: float, x: float = 0.0) -> str:
    terms = f'ixx="{mass * xx / 12}" iyy="{mass * yy / 12}" izz="{mass * zz / 12}" ixy="0" ixz="0" iyz="0"'
    return f'<inertial><origin xyz="{x} 0 0"/><mass value="{mass}"/><inertia {terms}/></inertial>'


def box(mass: float, sizes: tuple[float, float, float], x: float = 0.0, z: float = 0.0) -> str:
    """The contents of a link that is a box; its moments are those of the formula m (a2 + b2) / 12."""
    a, b, c = (size * size for size in sizes)
    size = " ".join(map(str, sizes))
    shape = f'<collision><origin xyz="{x} 0 {z}"/><geometry><box size="{size}"/></geometry></collision>'
    return inertial(mass, b + c, a + c, a + b, x) + shape


def rover_urdf(path: Path) -> Path:
    parts = [f'<link name="chassis">{box(10.0, (0.5, 0.26, 0.08))}</link>']
    across, about = 3 * 0.08**2 + 0.04**2, 6 * 0.08**2
    for name, (x, y) in WHEELS.items():
        shape = '<origin rpy="1.5707963267948966 0 0"/><geometry><cylinder radius="0.08" length="0.04"/></geometry>'
        parts.append(
            f'<link name="{name}_wheel">{inertial(0.5, across, about, across)}<collision>{shape}</collision></link>'
            f'<joint name="{name}_joint" type="continuous"><parent link="chassis"/><child link="{name}_wheel"/>'
            f'<origin xyz="{x} {y} -0.02"/><axis xyz="0 1 0"/></joint>'
        )
    path.write_text(f'<robot name="rover">{"".join(parts)}</robot>', encoding="utf-8")
    return path


def arm_urdf(folder: Path) -> Path:
    parts = [f'<link name="world"/><link name="base">{box(5.0, (0.2, 0.2, 0.1), z=0.05)}</link>']
    parts.append('<joint name="hold" type="fixed"><parent link="world"/><child link="base"/></joint>')
    for name, above, at in (("upper", "base", "0 0 0.2"), ("lower", "upper", "0.3 0 0")):
        parts.append(
            f'<link name="{name}">{box(1.0, (0.3, 0.04, 0.04), 0.15)}</link><joint name="{name}_joint" type="revolute">'
            f'<parent link="{above}"/><child link="{name}"/><origin xyz="{at}"/><axis xyz="0 1 0"/>'
            '<limit lower="-1.5707963267948966" upper="1.5707963267948966" effort="87" velocity="0"/></joint>'
        )
    (folder / "arm.urdf").write_text(f'<robot name="arm">{"".join(parts)}</robot>', encoding="utf-8")
    drive = "{drive: {stiffness: 400.0, damping: 40.0, max_force: 87.0}}"
    text = f"robot: arm\nurdf: arm.urdf\nbase_link: world\njoints: {{upper_joint: {drive}, lower_joint: {drive}}}\n"
    (folder / "arm.yaml").write_text(text, encoding="utf-8")
    return folder / "arm.yaml"


def driven(use: Path, left: float, right: float) -> list[float]:
    """Where a rover is, and how fast it turns, while its wheels turn with these speeds."""
    (use.parent / "scene.yaml").write_text(WORLD.format(use.name, 0.1), encoding="utf-8")
    found: list[float] = []
    with ge.load(use.parent / "scene.yaml").session() as sim:
        sim.run(0.5)
        speeds = {f"{name}_joint": left if name.endswith("l") else right for name in WHEELS}
        sim.robots["bot"].command(velocities=speeds)
        for _ in range(3):
            sim.run(0.7)
            robot = sim.robots["bot"]
            found += [*robot.pose.position, *robot.pose.orientation]
    return found


@pytest.mark.parametrize(("left", "right"), [(5.0, 5.0), (-3.0, 3.0), (2.0, 4.0)])
def test_a_rover_drives_as_its_urdf_does(tmp_path: Path, left: float, right: float) -> None:
    as_stage = driven(rover(tmp_path / "rover.usda"), left, right)
    as_urdf = driven(rover_urdf(tmp_path / "rover.urdf"), left, right)
    assert as_stage == pytest.approx(as_urdf, rel=0.01, abs=0.002)


def swung(use: Path) -> list[float]:
    """The joint positions of an arm on its way to other targets."""
    (use.parent / "scene.yaml").write_text(WORLD.format(use.name, 0.0), encoding="utf-8")
    found: list[float] = []
    with ge.load(use.parent / "scene.yaml").session() as sim:
        sim.robots["bot"].command(positions={"upper_joint": -0.8, "lower_joint": 1.2})
        for _ in range(10):
            sim.run(0.05)
            found += [joint.position for joint in sim.robots["bot"].joints.values()]
    return found


def test_an_arm_swings_as_its_urdf_does(tmp_path: Path) -> None:
    as_stage, as_urdf = swung(arm(tmp_path / "arm.usda")), swung(arm_urdf(tmp_path))
    assert as_stage == pytest.approx(as_urdf, rel=0.01, abs=1e-4)
    assert max(map(abs, as_urdf)) > 0.5
