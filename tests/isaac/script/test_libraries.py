"""Scripts that only define functions and classes: what can be called of them, and what they build when it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.cli import main

LIBRARY = """\
import omni.graph.core as og
from my_ext.names import PREFIX
from ..names import TICK
from .parts.clock import clock
from .helper import wires

class Builder:
    def __init__(self, path: str, world=None):
        self.path = path
    def _edit(self, nodes):
        commands = {"create_nodes": nodes, "connect": wires()}
        og.Controller.edit({"graph_path": self.path, "evaluator_name": "execution"}, commands)
    def build(self, name, *, rate: int = 2):
        self._edit([(PREFIX + "Tick", TICK), clock(name)])
    @staticmethod
    def plain(path):
        og.Controller.create_graph(path)

async def build_one(robot: str, rate: float = 2.0) -> None:
    Builder(robot).build("Clock")

def set_up(robot):
    print(robot)

if __name__ == "__main__":
    raise SystemExit("not to be run")
"""


@pytest.fixture
def library(tmp_path: Path) -> Path:
    folder = tmp_path / "my_ext" / "robots" / "parts"
    folder.mkdir(parents=True)
    (folder.parents[1] / "names.py").write_text("TICK, PREFIX = 'omni.graph.action.OnPlaybackTick', 'On'\n")
    (folder.parent / "helper.py").write_text("def wires(): return [('OnTick.outputs:tick', 'Clock.inputs:execIn')]\n")
    (folder / "clock.py").write_text("def clock(name): return name, 'isaacsim.ros2.bridge.ROS2PublishClock'\n")
    (folder.parent / "build.py").write_text(LIBRARY, encoding="utf-8")
    return folder.parent / "build.py"


def test_what_can_be_called_is_listed_with_its_arguments(
    library: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    library.write_text(LIBRARY.partition("if __name__")[0], encoding="utf-8")
    assert main(["import", str(library), "-o", str(tmp_path)]) == 1
    err = capsys.readouterr().err
    assert [line.strip() for line in err.split("\n") if ", line " in line] == [
        "Builder.plain(path), line 16",
        "build_one(robot: str, rate: float=2.0), line 19",
    ]


@pytest.mark.parametrize("call", ["build_one('/World/x')", "Builder('/World/x', world=None).build('Clock', rate=3)"])
def test_what_is_called_builds_its_graph_as_part_of_its_package(call: str, library: Path, tmp_path: Path) -> None:
    given = ["import", str(library), "-o", str(tmp_path), "--allow", str(tmp_path), "--call", call]
    assert main(given) == 0
    text = (tmp_path / "x.yaml").read_text(encoding="utf-8")
    assert "OnTick: omni.graph.action.OnPlaybackTick" in text
    assert "OnTick.tick -> Clock.execIn" in text


def test_modules_above_a_script_are_named_with_the_folder_that_may_be_allowed(
    library: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["import", str(library), "-o", str(tmp_path), "--call", "build_one('/World/x')"]) == 1
    err = capsys.readouterr().err
    assert f"build.py:2:1: module 'my_ext' is not imported; --allow {tmp_path} lets it be imported" in err
    assert f"build.py:3:1: module 'names' is not imported; --allow {tmp_path / 'my_ext'} lets it be imported" in err
    assert "'parts" not in err
    assert "'helper" not in err


@pytest.mark.parametrize("call", ["build", "__import__('os').system", "(", "build(\0)", "x = build()"])
def test_a_call_is_a_call(call: str, library: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(["import", str(library), "--call", call])
    assert "is not a call; write build('/World/robot', rate=2)" in capsys.readouterr().err


BROKEN = """
from nowhere import settings
CONFIG = settings.read(arguments.file)
class Place:
    def __init__(self, path):
        self.path = path
def build(place, world):
    import omni.graph.core as og
    og.Controller.edit(place.path, {"create_nodes": ("T", "omni.graph.action.OnTick")})
"""


def test_a_script_that_fails_lists_what_can_be_called_and_a_call_goes_on_behind_the_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "broken.py").write_text(BROKEN, encoding="utf-8")
    given = ["import", str(tmp_path / "broken.py"), "-o", str(tmp_path)]
    assert main(given) == 1
    said = capsys.readouterr().err
    assert "broken.py:3:24: error G401: NameError: name 'arguments' is not defined" in said
    assert "  build(place, world), line 7" in said
    assert main([*given, "--call", "build(Place('/World/' + 'g'), world)"]) == 0
    out, said = capsys.readouterr()
    assert "note: world in the call: taken to be what only Omniverse knows" in out
    assert "3:24: warning W302: NameError: name 'arguments' is not defined; what follows is built without" in said
    assert (tmp_path / "g.yaml").is_file()


EXTENSION = """
import omni.ext
import omni.graph.core as og
class Robot(omni.ext.IExt):
    def on_startup(self, ext_id):
        self.build()
    def build(self):
        og.Controller.edit("/World/g", {"create_nodes": ("T", "omni.graph.action.OnTick")})
"""


@pytest.mark.parametrize("start", ["", "Robot().on_startup('mine')\n"])
def test_an_extension_is_started_once(start: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "extension.py").write_text(EXTENSION + start, encoding="utf-8")
    assert main(["import", str(tmp_path / "extension.py"), "-o", str(tmp_path)]) == 0
    assert ("Robot.on_startup is called" in capsys.readouterr().out) == (not start)
    assert (tmp_path / "g.yaml").is_file()
