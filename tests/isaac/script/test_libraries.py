"""Scripts that only define functions and classes: what can be called of them, and what they build when it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.harness import Graphrun

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


def test_what_can_be_called_is_listed_with_its_arguments(library: Path, imports: Graphrun) -> None:
    library.write_text(LIBRARY.partition("if __name__")[0], encoding="utf-8")
    done = imports(library)
    assert done.code == 1
    assert [line.strip() for line in done.err.split("\n") if ", line " in line] == [
        "Builder.plain(path), line 16",
        "build_one(robot: str, rate: float=2.0), line 19",
    ]


@pytest.mark.parametrize("call", ["build_one('/World/x')", "Builder('/World/x', world=None).build('Clock', rate=3)"])
def test_what_is_called_builds_its_graph_as_part_of_its_package(
    call: str, library: Path, imports: Graphrun, tmp_path: Path
) -> None:
    assert imports(library, "--allow", str(tmp_path), "--call", call).code == 0
    text = (tmp_path / "x.yaml").read_text(encoding="utf-8")
    assert "OnTick: omni.graph.action.OnPlaybackTick" in text
    assert "OnTick.tick -> Clock.execIn" in text


def test_modules_above_a_script_are_named_with_the_folder_that_may_be_allowed(
    library: Path, imports: Graphrun, tmp_path: Path
) -> None:
    done = imports(library, "--call", "build_one('/World/x')")
    err = done.err
    assert done.code == 1
    assert f"build.py:2:1: note N302: module 'my_ext' is not imported; to import it, add --allow {tmp_path}" in err
    assert (
        f"build.py:3:1: note N302: module 'names' is not imported; to import it, add --allow {tmp_path / 'my_ext'}"
        in err
    )
    assert "'parts" not in err
    assert "'helper" not in err


@pytest.mark.parametrize("call", ["build", "__import__('os').system", "(", "build(\0)", "x = build()"])
def test_a_call_is_a_call(call: str, library: Path, imports: Graphrun) -> None:
    done = imports(library, "--call", call)
    assert (done.code, "is not a function call; write build('/World/robot', rate=2)" in done.err) == (2, True)


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
    imports: Graphrun, tmp_path: Path
) -> None:
    done = imports(BROKEN)
    assert done.code == 1
    assert "script.py:3:24: error G401: NameError: name 'arguments' is not defined" in done.err
    assert "  build(place, world), line 7" in done.err
    done = imports(BROKEN, "--call", "build(Place('/World/' + 'g'), world)")
    assert done.code == 0
    assert "note N302: world in --call: undefined names, assumed to be objects of Omniverse" in done.out
    assert "3:24: warning W302: NameError: name 'arguments' is not defined; the script continues after" in done.err
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
def test_an_extension_is_started_once(start: str, imports: Graphrun, tmp_path: Path) -> None:
    done = imports(EXTENSION + start)
    assert (done.code, "Robot.on_startup is called" in done.out) == (0, not start)
    assert (tmp_path / "g.yaml").is_file()
