"""Strangers' files on kernels with and without the borders that confine them: the table of docs/how/security.md."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from graphengine.format.files import shipped
from graphengine.sandbox.borders import missing
from tests.descriptions.files.test_meshes import collada, instance
from tests.physics.harness import Project
from tests.sandbox import kernels

pytest.importorskip("pxr")
pytestmark = pytest.mark.skipif(bool(missing()), reason="this machine lacks a border itself")

SCRIPT = """import omni.graph.core as og
og.Controller.edit("/g", {og.Controller.Keys.CREATE_NODES: [(f"T{i}", "omni.graph.action.OnTick") for i in range(2)]})
"""
STAGE = """#usda 1.0
def OmniGraph "G" {
    def OmniGraphNode "T" {
        token node:type = "omni.graph.action.OnTick"
    }
}
"""
XACRO = """<robot name="cart" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <link name="base_link">
    <inertial><mass value="${2 + 3}"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
</robot>
"""
MESH = XACRO.replace("${2 + 3}", "5").replace(
    "</link>", '<visual><geometry><mesh filename="body.dae"/></geometry></visual></link>'
)
SCENE = "scene: test\nworld: world.xml\nrobots:\n"
SCENE += "  a: {{use: {0}, position: [0, 0, 0.1]}}\n  b: {{use: {0}, position: [2, 0, 1]}}\n"

ROBOT = """#usda 1.0
(
    metersPerUnit = 1
    upAxis = "Z"
)
def Cube "box" (apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsCollisionAPI"]) {
}
"""
COMMANDS = {
    "script": ["import", "script.py", "-o", "out", "--force"],
    "stage": ["import", "stage.usda", "-o", "out", "--force"],
    "trusted script": ["import", "script.py", "-o", "out", "--force", "--trust"],
    "trusted stage": ["import", "stage.usda", "-o", "out", "--force", "--trust"],
    "robot": ["check", "robot.yaml"],
    "xacro": ["check", "xacro.yaml"],
    "mesh": ["check", "mesh.yaml"],
}
RUN = """
import contextlib, io, json, sys
from graphengine.cli import main
told = {}
for name, command in json.loads(sys.argv[1]).items():
    with contextlib.redirect_stdout(io.StringIO()) as out, contextlib.redirect_stderr(io.StringIO()) as error:
        code = main(command)
    told[name] = code, out.getvalue() + error.getvalue()
print(json.dumps(told))
"""
ROWS = {"script": ["script"], "stage": ["stage"], "robot of a stage": ["robot"], "xacro": ["xacro"], "mesh": ["mesh"]}
ROWS["script or stage with `--trust`"] = ["trusted script", "trusted stage"]
COLUMNS = {"both": [], "no Landlock": ["Landlock"], "no seccomp": ["seccomp"], "neither": ["Landlock", "seccomp"]}
CELLS = {"runs": 0, "refused, G401": 0, "runs, W206": 1, "runs, one W206": 1}
"""What the manual's cells say happens, and how often W206 is reported."""


def table() -> dict[str, dict[str, tuple[str, int]]]:
    """By column and command: what the manual says happens, and the exit code."""
    lines = (shipped() / "docs" / "how" / "security.md").read_text(encoding="utf-8").splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| | both |"))
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[start : start + 8]]
    found: dict[str, dict[str, tuple[str, int]]] = {name: {} for name in rows[0][1:]}
    for head, *cells in rows[2:]:
        for column, cell in zip(rows[0][1:], cells, strict=True):
            what, _, code = cell.partition(": ")
            found[column] |= {command: (what, int(code)) for command in ROWS[head]}
    return found


@pytest.fixture
def files(tmp_path: Path) -> Path:
    project = Project(tmp_path).write("script.py", SCRIPT).write("stage.usda", STAGE)
    project.write("cart.urdf.xacro", XACRO).write("cart.urdf", MESH).write("body.dae", collada(instance()).decode())
    project.write("robot.usda", ROBOT).write("robot.yaml", SCENE.format("robot.usda"))
    project.write("xacro.yaml", SCENE.format("cart.urdf.xacro")).write("mesh.yaml", SCENE.format("cart.urdf"))
    (tmp_path / "out").mkdir()
    return tmp_path


@pytest.mark.parametrize("column", COLUMNS)
def test_the_outcome_agrees_with_the_manual(column: str, files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    done = kernels.run(RUN, COLUMNS[column], json.dumps(COMMANDS))
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    expected = table()[column]
    assert list(told) == list(COMMANDS)
    for name, (code, text) in told.items():
        what, wanted = expected[name]
        assert (name, code) == (name, wanted), text
        assert text.count("warning W206") == CELLS[what], text
        assert ("G401" in text) == ("G401" in what), text
        for border in COLUMNS[column]:
            assert border in text
        if what.startswith("refused"):
            assert "--trust runs" in text


@pytest.mark.parametrize("column", COLUMNS)
def test_the_abi_version_decides_which_restrictions_apply(column: str) -> None:
    code = "import sys\nfrom graphengine.cli import main\nmain(['--version', '--verbose'])"
    line = kernels.run(code, COLUMNS[column]).stdout.splitlines()[1]
    there = {name: "no" if name in COLUMNS[column] else "yes" for name in ("Landlock", "seccomp")}
    assert line == f"confinement: Landlock: {there['Landlock']}, seccomp: {there['seccomp']}"


def test_a_script_of_literals_needs_no_border(files: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(files)
    (files / "script.py").write_text(
        'import omni.graph.core as og\nog.Controller.edit("/g", {"create_nodes": [("T", "omni.graph.action.OnTick")]})\n'
    )
    done = kernels.run(RUN, COLUMNS["neither"], json.dumps({"script": COMMANDS["script"]}))
    code, text = json.loads(done.stdout)["script"]
    assert (code, "W206" in text) == (0, False)
