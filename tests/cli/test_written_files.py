"""Files that verbs write: a link that a stranger planted at the temporary name of one leads nowhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.harness import Graphrun
from tests.physics.pictures.harness import needs_opengl

SCRIPT = (
    'import omni.graph.core as og\nog.Controller.edit("/g", {"create_nodes": [("T", "omni.graph.action.OnTick")]})\n'
)
URDF = """<robot name="cart"><link name="base"><inertial><mass value="1"/>
<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>
"""
WORLD = '<mujoco><worldbody><geom type="box" size="1 0.1 1" pos="0 1 1"/></worldbody></mujoco>\n'
FILES = {
    "script.py": SCRIPT,
    "cart.urdf": URDF,
    "world.xml": WORLD,
    "room.yaml": "scene: room\nworld: world.xml\n",
}
WRITTEN = {
    "show mine.yaml --svg x.svg": ["x.svg"],
    "show mine.yaml --html x.html": ["x.html"],
    "export mine.yaml --to isaac-script -o x.py": ["x.py"],
    "import script.py -o out": ["out/g.yaml"],
    "import-robot cart.urdf -o x.yaml": ["x.yaml"],
    "map room.yaml -o x --bounds -1 -1 1 1": ["x.png", "x.yaml"],
    "snapshot room.yaml --size 8x8 -o x.png": ["x.png"],
}
DRAWN = [pytest.param(command, marks=[needs_opengl] if command.startswith("snapshot") else []) for command in WRITTEN]


@pytest.mark.parametrize("command", DRAWN)
def test_a_link_at_the_name_of_a_part_is_not_followed(graphrun: Graphrun, project: Path, command: str) -> None:
    for name, text in FILES.items():
        (project / name).write_text(text, encoding="utf-8")
    (project / "out").mkdir()
    victim = project / "victim"
    victim.write_bytes(b"mine")
    for path in map(Path, WRITTEN[command]):
        path.with_name(f".{path.name}.part").symlink_to(victim)
    result = graphrun(*command.split())
    assert (result.code, victim.read_bytes()) == (0, b"mine"), result.err
    assert all(Path(path).stat().st_size and not Path(path).is_symlink() for path in WRITTEN[command])
