"""`graphrun import-robot`, `graphrun new` and `use:` make robots of USD stages, and the robots move as their stages say."""

from __future__ import annotations

import importlib.util
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import yaml

pytest.importorskip("pxr")

from pxr import Sdf, Usd, UsdPhysics, UsdUtils

import graphengine as ge
from graphengine.descriptions.usd import stage_files, usd_reader
from graphengine.sandbox.confinement import ProcessError
from tests.cli.harness import Graphrun
from tests.descriptions.usd.stages import WHEELS, StageWriter, arm, rover

SCENE = "scene: s\nworld: worlds/flat_grid.xml\nrobots:\n  bot: {{use: {}, position: [0, 0, 0.1]}}\n"
UNITS: list[dict[str, Any]] = [{}, {"metres": 0.01, "kilograms": 0.001, "up": "Y"}]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def robot_of(path: str) -> Any:
    return yaml.safe_load(Path(path).read_text(encoding="utf-8"))


def scene_of(use: str) -> ge.Scene:
    Path("scene.yaml").write_text(SCENE.format(use), encoding="utf-8")
    return ge.load("scene.yaml")


@pytest.mark.parametrize("units", UNITS)
def test_a_robot_whose_graph_commands_velocities_drives_as_imported(
    folder: Path, graphrun: Graphrun, units: dict[str, Any]
) -> None:
    rover(folder / "rover.usda", stiffness=1000.0, **units)
    result = graphrun("import-robot", "rover.usda", "-o", "robots/rover.yaml", code=0)
    assert "5 links, 4 joints of which 4 move, 12 kg" in result.lines
    assert "driven wheels of the base with a velocity command" in result.out
    robot = robot_of("robots/rover.yaml")
    assert robot["usd"] == "../rover.usda"
    assert not any("stiffness" in joint["drive"] for joint in robot["joints"].values())
    assert robot["graphs"]["base"]["parameters"] | {"radius": 0.08} == robot["graphs"]["base"]["parameters"]
    with scene_of("robots/rover.yaml").session() as sim:
        sim.run(0.5)
        sim.robots["bot"].publish("cmd_vel", {"linear": {"x": 0.4}}, every=0.1, type="geometry_msgs/msg/Twist")
        sim.run(2.0)
        ramp = 0.4**2 / 2  # the distance that the ramp of 1 m/s2 costs, m
        assert sim.robots["bot"].pose.position[0] == pytest.approx(0.4 * 2.0 - ramp, rel=0.03)


def test_a_stage_is_used_without_a_robot_file(folder: Path) -> None:
    rover(folder / "rover.usda", stiffness=1000.0)
    with scene_of("rover.usda").session() as sim:
        sim.run(0.5)
        sim.robots["bot"].command(velocities={f"{name}_joint": 5.0 for name in WHEELS})
        sim.run(2.0)
        assert sim.robots["bot"].pose.position[0] == pytest.approx(5.0 * 0.08 * 2.0, rel=0.03)


@pytest.mark.parametrize("units", UNITS)
def test_an_arm_holds_as_stiffly_as_its_drives_say(folder: Path, units: dict[str, Any]) -> None:
    """Its joints sag by the torque of the links beyond them divided by the stiffness."""
    arm(folder / "arm.usda", gains=(400.0, 40.0), **units)
    with scene_of("arm.usda").session() as sim:
        sim.run(3.0)
        upper, lower = (abs(sim.robots["bot"].joints[f"{name}_joint"].position) for name in ("upper", "lower"))
    reach = math.cos(upper + lower)
    assert lower == pytest.approx(9.81 * 0.15 * reach / 400.0, rel=0.01)
    assert upper == pytest.approx(
        9.81 * (0.15 * math.cos(upper) + 0.3 * math.cos(upper) + 0.15 * reach) / 400.0, rel=0.01
    )


def test_a_project_holds_the_files_of_the_stage(folder: Path, graphrun: Graphrun) -> None:
    arm(folder / "parts/arm.usda")
    (folder / "cell.usda").write_text(
        '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n    subLayers = [@parts/arm.usda@]\n)\n'
    )
    graphrun("new", "made", "--from", "cell.usda", code=0)
    assert robot_of("made/robots/made.yaml")["usd"] == "made_stage/cell.usda"
    assert "[usd,view]" in Path("made/requirements.txt").read_text(encoding="utf-8")
    (folder / "parts/arm.usda").unlink()
    (folder / "cell.usda").unlink()
    graphrun("run", "made/made.yaml", "--transport", "memory", "--for", "0.1s", code=0)


def test_packages_are_read(folder: Path, graphrun: Graphrun) -> None:
    arm(folder / "arm.usda")
    UsdUtils.CreateNewUsdzPackage("arm.usda", "packed.usdz")
    graphrun("import-robot", "packed.usdz", "-o", "arm.yaml", code=0)


def test_one_robot_of_several_is_chosen(folder: Path, graphrun: Graphrun) -> None:
    writer = StageWriter(folder / "two.usda")
    for name in ("one", "other"):
        writer.robot(f"/{name}")
        writer.body(f"/{name}/base", mass=1.0)
        writer.body(f"/{name}/wheel", mass=1.0)
        writer.joint("Revolute", f"/{name}/joint", (f"/{name}/base", f"/{name}/wheel"))
    writer.save()
    refused = graphrun("import-robot", "two.usda", "-o", "a.yaml", code=1).err
    assert "the stage has more than one robot" in refused
    assert "its robots: /one, /other" in refused
    graphrun("import-robot", "two.usda", "--model", "/other", "-o", "a.yaml", code=0)
    assert robot_of("a.yaml")["usd_robot"] == "/other"
    assert "no robot 'third'" in graphrun("import-robot", "two.usda", "--model", "third", "-o", "b.yaml", code=1).err


def test_a_variant_is_selected(folder: Path, graphrun: Graphrun) -> None:
    arm(folder / "arm.usda")
    stage = Usd.Stage.Open("arm.usda")
    variants = stage.GetPrimAtPath("/Arm").GetVariantSets().AddVariantSet("load")
    for name, mass in (("empty", 1.0), ("full", 3.0)):
        variants.AddVariant(name)
        variants.SetVariantSelection(name)
        with variants.GetVariantEditContext():
            UsdPhysics.MassAPI.Apply(stage.OverridePrim("/Arm/tool")).CreateMassAttr(mass)
            UsdPhysics.RigidBodyAPI.Apply(stage.GetPrimAtPath("/Arm/tool"))
    variants.SetVariantSelection("empty")
    joint = UsdPhysics.FixedJoint.Define(stage, "/Arm/mount")
    joint.CreateBody0Rel().SetTargets([Sdf.Path("/Arm/lower")])
    joint.CreateBody1Rel().SetTargets([Sdf.Path("/Arm/tool")])
    stage.Save()
    assert "8 kg" in graphrun("import-robot", "arm.usda", "-o", "a.yaml", code=0).out
    assert "10 kg" in graphrun("import-robot", "arm.usda", "--variant", "load=full", "-o", "b.yaml", code=0).out
    assert robot_of("b.yaml")["usd_variants"] == {"load": "full"}
    graphrun("import-robot", "arm.usda", "--variant", "/Arm:load=full", "-o", "c.yaml", code=0)
    wrong = graphrun("import-robot", "arm.usda", "--variant", "load=half", "-o", "d.yaml", code=1).err
    assert "no variant load=half; known: empty, full" in wrong


def test_assets_on_servers_are_named_and_brought_by_a_mirror_or_one_by_one(folder: Path, graphrun: Graphrun) -> None:
    url = "https://assets.example/Isaac/5.0/Robots/arm.usda"
    (folder / "cell.usda").write_text(
        f'#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\ndef "Cell" (\n    references = @{url}@</Arm>\n) {{\n}}\n'
    )
    alone = graphrun("import-robot", "cell.usda", "-o", "a.yaml", code=1).err
    assert f"{url} is left out: it is on a server, which is never asked; needed by /Cell" in alone
    assert "--assets FOLDER" in alone
    arm(folder / "mirror/Robots/arm.usda")
    graphrun("import-robot", "cell.usda", "--assets", "mirror", "-o", "a.yaml", code=0)
    graphrun("import-robot", "cell.usda", "--replace", f"{url}=mirror/Robots/arm.usda", "-o", "b.yaml", code=0)
    for name in ("a", "b"):
        Path("scene.yaml").write_text(SCENE.format(f"{name}.yaml"), encoding="utf-8")
        graphrun("run", "scene.yaml", "--allow", "mirror", "--transport", "memory", "--for", "0.1s", code=0)


def test_without_usd_core_one_line_says_what_to_install(
    folder: Path, graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch
) -> None:
    arm(folder / "arm.usda")
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == "pxr" else find(name, *more))
    assert "reading stages needs usd-core" in graphrun("import-robot", "arm.usda", "-o", "a.yaml", code=2).err
    Path("scene.yaml").write_text(SCENE.format("arm.usda"), encoding="utf-8")
    told = graphrun("check", "scene.yaml", code=1)
    assert "reading stages needs usd-core" in told.out + told.err


def test_a_library_that_replaces_that_of_usd_core_is_named(
    folder: Path, graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch
) -> None:
    def crash(*_: object) -> bytes:
        raise ProcessError("crashed: Aborted", b"")

    arm(folder / "arm.usda")
    rival = SimpleNamespace(name="usd-exchange")
    monkeypatch.setattr(usd_reader, "ask", crash)
    monkeypatch.setattr(stage_files, "distributions", lambda name: [rival] if name == rival.name else [])
    told = graphrun("import-robot", "arm.usda", "-o", "a.yaml", code=1).err
    assert "USD's reader crashed: Aborted" in told
    assert "usd-exchange is installed, which replaces the library of usd-core: uninstall it" in told


def test_a_stage_without_bodies_has_no_robot(folder: Path, graphrun: Graphrun) -> None:
    (folder / "empty.usda").write_text('#usda 1.0\ndef Xform "A" {\n}\n')
    assert "no rigid body, so it has no robot" in graphrun("import-robot", "empty.usda", "-o", "a.yaml", code=1).err
    (folder / "bad.usda").write_text("#usda 1.0\ndef {\n")
    assert "bad.usda:2:" in graphrun("import-robot", "bad.usda", "-o", "a.yaml", code=1).err
