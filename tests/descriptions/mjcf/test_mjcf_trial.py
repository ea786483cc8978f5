"""Worlds are compiled in a confined process first, unless they are small and plain."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.descriptions.files.references import Library
from graphengine.descriptions.mjcf import mjcf_trial
from graphengine.descriptions.mjcf.mjcf_trial import is_plain
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.sandbox.confinement import ProcessError, ask
from tests.physics.harness import SHIPPED, Project, try_load

MESH = '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
MODEL = """<sdf version="1.7"><world name="w"><model name="m"><link name="l"><collision name="c"><geometry>
<mesh><uri>a.obj</uri></mesh></geometry></collision></link></model></world></sdf>"""


@pytest.fixture
def rehearsed(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """The requests to the confined process, which runs as always."""
    requests: list[bytes] = []

    def record(module: str, request: bytes, seconds: float) -> bytes:
        requests.append(request)
        return ask(module, request, seconds)

    monkeypatch.setattr(mjcf_trial, "ask", record)
    monkeypatch.setattr(mjcf_trial, "_passed", set())
    return requests


@pytest.mark.parametrize("path", [*sorted(SHIPPED.glob("*.yaml")), *sorted(SHIPPED.glob("tutorial/*.yaml"))], ids=str)
def test_the_scenes_of_this_package_start_no_process(rehearsed: list[bytes], path: Path) -> None:
    assert try_load(path)[0] is not None
    assert rehearsed == []


@pytest.mark.parametrize(
    "world",
    [
        f'<mujoco>{MESH}<worldbody><geom type="mesh" mesh="m"/></worldbody></mujoco>',
        '<mujoco><worldbody><replicate count="2" offset="1 0 0"><geom size=".1"/></replicate></worldbody></mujoco>',
        f"<mujoco><worldbody>{'<site/>' * 4100}</worldbody></mujoco>",
        '<mujoco><asset><texture name="t" type="2d" builtin="flat" width="2900" height="2900"/></asset></mujoco>',
    ],
    ids=["mesh", "replicate", "many", "texture"],
)
def test_a_world_that_is_not_small_and_plain_is_compiled_in_the_confined_process_once(
    project: Project, rehearsed: list[bytes], world: str
) -> None:
    project.write("world.xml", world).write("scene.yaml", "scene: test\nworld: world.xml\n")
    project.load()
    assert len(rehearsed) == 1
    project.load()
    assert len(rehearsed) == 1


def test_an_sdf_world_with_meshes_is_compiled_in_the_confined_process(project: Project, rehearsed: list[bytes]) -> None:
    project.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    project.write("world.sdf", MODEL).write("scene.yaml", "scene: test\nworld: world.sdf\n").load()
    (request,) = rehearsed
    assert b"v 0 0 0\nv 1 0 0" in request


@pytest.mark.parametrize("suffix", [".xml", ".sdf"])
def test_a_world_that_compiles_for_too_long_is_refused_with_the_limits(
    project: Project, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    """The process ends by its limit of CPU time, here one second, while MuJoCo makes 30 000 copies."""
    monkeypatch.setattr(mjcf_trial, "MAX_SECONDS", 1.0)
    copies = '<replicate count="30000" offset="3 0 0"><body><geom size="1"/></body></replicate>'
    project.write("world.xml", f"<mujoco><worldbody>{copies}</worldbody></mujoco>")
    if suffix == ".sdf":
        links = "".join(f'<link name="l{number}"/>' for number in range(30_000))
        text = f'<sdf version="1.7"><world name="w"><model name="m"><static>1</static>{links}</model></world></sdf>'
        project.write("world.sdf", text)
    error = project.write("scene.yaml", f"scene: test\nworld: world{suffix}\n").error()
    assert f"world{suffix}:1:" in error
    assert "error S102: MuJoCo: compiling the world takes more than 1 s" in error
    assert "legal: up to 20 s of CPU time and 3 GB of memory" in error
    assert "use fewer bodies and copies, smaller textures and coarser meshes" in error


def test_a_world_that_ends_the_process_is_refused(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    def crash(*_: object) -> bytes:
        raise ProcessError("crashed: Segmentation fault", b"")

    monkeypatch.setattr(mjcf_trial, "ask", crash)
    project.write("world.xml", f'<mujoco model="crash">{MESH}</mujoco>')
    assert "error S102: MuJoCo: compiling the world crashed: Segmentation fault" in project.error()


def test_a_class_whose_name_is_a_format_of_printf_ends_only_the_confined_process(project: Project) -> None:
    """MuJoCo reads memory that it does not have, in the message that the class is unknown."""
    project.write("world.xml", f'<mujoco><worldbody><geom size="1" class="{100 * "%s%n"}"/></worldbody></mujoco>')
    assert "error S102: MuJoCo: compiling the world crash" in project.error()


@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("<mujoco><worldbody><body><freejoint/><geom/></body></worldbody></mujoco>", True),
        (f"<mujoco><worldbody>{3990 * '<site/>'}</worldbody></mujoco>", True),
        (f"<mujoco><worldbody>{4000 * '<site/>'}</worldbody></mujoco>", False),
        ('<mujoco><custom><numeric name="n" data="1 2"/></custom></mujoco>', True),
        ('<mujoco><custom><numeric name="n" size="9999"/></custom></mujoco>', False),
        ("<mujoco><actuator/></mujoco>", False),
        ("<mujoco><tendon/></mujoco>", False),
        ('<mujoco><default><mesh scale="1 1 1"/></default></mujoco>', False),
        (
            '<mujoco><worldbody><flexcomp name="f" type="grid" count="2 2 2" spacing="1 1 1"/></worldbody></mujoco>',
            False,
        ),
        ('<mujoco><asset><texture name="t" file="a.png"/></asset></mujoco>', False),
        (f"<mujoco><worldbody>{150 * '<body><freejoint/><geom/></body>'}</worldbody></mujoco>", True),
        (f"<mujoco><worldbody>{200 * '<body><freejoint/><geom/></body>'}</worldbody></mujoco>", False),
        (f'<mujoco><worldbody><geom name="{1000 * "n"}"/></worldbody></mujoco>', True),
        (f'<mujoco><worldbody><geom name="{1001 * "n"}"/></worldbody></mujoco>', False),
        ('<mujoco><worldbody><geom class="%n"/></worldbody></mujoco>', False),
    ],
)
def test_only_small_models_of_plain_elements_are_plain(tmp_path: Path, text: str, plain: bool) -> None:
    (tmp_path / "a.png").touch()
    library = Library(Files((tmp_path,)), Findings())
    root = library.world(tmp_path / "world.xml", text)
    assert root is not None
    assert is_plain(root, library.memory) == plain
