"""A node of a user's module runs in a graph; one that raises, and physics that diverges, end the run as they should."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from graphengine.cli.common import make_registry
from graphengine.format.errors import NodeError
from tests.cli.harness import Result, process
from tests.jobs.harness import Job

NODES = '''"""Nodes of a user."""

from graphengine.node import Context
from graphengine.node import ExecIn, ExecOut, In, Node, Out, Bound, State


class Square(Node, type="mine.Square"):
    """The square of a number."""

    number: float = In(default=0.0, doc="what is squared")
    square: float = Out(doc="the number times itself")

    def compute(self) -> None:
        """Square it."""
        self.square = self.number * self.number


class Say(Node, type="mine.Say"):
    """Tells a number when it is reached."""

    exec_in = ExecIn()
    number: float = In(default=0.0, doc="what is told")
    at: float = In(default=25.0, doc="when it is told")
    exec_out = ExecOut()

    context: Context = Bound()

    def setup(self, context: Context) -> None:
        """Remember whom to tell."""
        self.context = context

    def compute(self) -> None:
        """Tell it."""
        if self.number == self.at:
            self.context.log("info", f"the number is {self.number:g}")


class Fragile(Node, type="mine.Fragile"):
    """Raises in every tick from a certain one on."""

    exec_in = ExecIn()
    tick: float = In(default=0.0, doc="number of the tick")
    until: float = In(default=1e9, doc="last tick that goes well")
    label: str = In(default="", doc="anything")
    exec_out = ExecOut()

    def compute(self) -> None:
        """Hold, or break."""
        if self.tick > self.until:
            raise OverflowError("too much")
'''

SQUARES = """format: 1
graph: squares
nodes:
  Tick: OnPlaybackTick
  Square: mine.Square
  Say: mine.Say
connections:
  - Tick.tick -> Say.execIn
  - Tick.frame -> Square.number
  - Square.square -> Say.number
"""

FRAGILE = """format: 1
graph: fragile
nodes:
  Tick: OnPlaybackTick
  Fragile:
    type: mine.Fragile
    inputs: {until: 90.0, label: a glass}
  Say: {type: mine.Say, inputs: {at: 100.0}}
  Behind: {type: mine.Say, inputs: {at: 90.0}}
connections:
  - Tick.tick -> Fragile.execIn
  - Tick.frame -> Fragile.tick
  - Tick.tick -> Say.execIn
  - Tick.frame -> Say.number
  - Fragile.execOut -> Behind.execIn
  - Tick.frame -> Behind.number
"""

SCENE = """format: 1
scene: fragile_scene
world: worlds/flat_grid.xml
settle: true
robots:
  dd100: {use: robots/tutorial_dd100.yaml, position: [0.0, 0.0, 0.02]}
graphs:
  fragile: {use: fragile.yaml}
"""

ABSURD_ROBOT = """robot: absurd
extends: robots/tutorial_dd100.yaml
joints:
  front_left_wheel_joint: {drive: {damping: 1.0e+5, target_velocity: 1.0e+9}}
"""
ABSURD = """scene: absurd
world: worlds/flat_grid.xml
physics: {tick_rate: 2, substeps: 1}
robots:
  dd100: {use: absurd_robot.yaml, position: [0.0, 0.0, 0.02]}
"""

Graphrun = Callable[..., Result]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    texts = {
        "my_nodes.py": NODES,
        "squares.yaml": SQUARES,
        "fragile.yaml": FRAGILE,
        "scene.yaml": SCENE,
        "absurd_robot.yaml": ABSURD_ROBOT,
        "absurd.yaml": ABSURD,
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture
def graphrun(folder: Path) -> Graphrun:
    return lambda *arguments, **ended: process(*arguments, "--transport", "memory", cwd=folder, **ended)


def test_a_node_of_a_module_in_the_working_directory_runs_in_a_graph(graphrun: Graphrun) -> None:
    result = graphrun("run", "squares.yaml", "--import", "my_nodes", "--for", "1s", code=0)
    assert "info: /World/squares/Say: the number is 25\n" in result.err


def test_without_the_import_its_type_is_unknown(graphrun: Graphrun) -> None:
    result = graphrun("run", "squares.yaml", "--for", "1s", code=1)
    assert "squares.yaml:5:11: error G201: unknown node type 'mine.Square'" in result.err


# A node that raises


def test_a_node_that_raises_stops_the_run_and_is_told_with_all_that_one_wants_to_know(graphrun: Graphrun) -> None:
    result = graphrun("run", "scene.yaml", "--import", "my_nodes", "--for", "5s", code=1, out="")
    line = NODES.split("\n").index('            raise OverflowError("too much")') + 1
    assert result.err.endswith(
        "error: fragile.yaml:5:3: node Fragile (mine.Fragile) raised OverflowError: too much\n"
        "  at tick 91, 1.51667 s, in graph fragile\n"
        "  inputs: tick=91.0, until=90.0, label='a glass'\n"
        f'  in compute, my_nodes.py:{line}: raise OverflowError("too much")\n'
    )
    assert re.search(r"^90 ticks, 1\.500 s of simulation|^91 ticks, 1\.517 s of simulation", result.err, re.MULTILINE)
    assert "Traceback" not in result.err


def test_with_keep_going_only_its_branch_ends(graphrun: Graphrun) -> None:
    result = graphrun("run", "scene.yaml", "--import", "my_nodes", "--for", "2s", "--keep-going", code=0)
    assert result.err.count("raised OverflowError: too much") == 1
    assert "info: /World/fragile/Behind: the number is 90\n" in result.err
    assert "info: /World/fragile/Say: the number is 100\n" in result.err
    assert re.search(r"^120 ticks, .*, 30 faults$", result.err, re.MULTILINE)


def test_commands_are_zeroed_before_the_run_ends(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    with Job(folder / "scene.yaml", registry=make_registry(["my_nodes"])) as job:
        job.say("/cmd_vel", 0.5, 0.0)
        job.run(1.0)
        world = job.session.services.world
        robot = world.articulation(world.stage.find("/dd100"))
        assert robot.velocities() == pytest.approx([5.0, 5.0], rel=0.01)  # 0.5 m/s by the tutorial's radius
        with pytest.raises(NodeError):
            job.run(5.0)
        assert job.session.clock.frame == 91
        for _ in range(4 * 60):
            world.step()
        assert robot.velocities() == pytest.approx([0.0, 0.0], abs=1e-3)
        assert np.allclose(world.body(world.stage.find("/dd100")).velocity(), 0.0, atol=1e-2)


# Physics


def test_physics_that_diverges_ends_the_run_with_what_moved_and_what_to_do(graphrun: Graphrun) -> None:
    result = graphrun("run", "absurd.yaml", "--for", "60s", code=1, out="")
    assert re.search(
        r"^error: the simulation diverged at t = \d+\.\d+ s: the motion of joint 'dd100/\w+'", result.err, re.MULTILINE
    )
    assert "raise physics.substeps, lower the drive's damping" in result.err
    assert "Traceback" not in result.err


def test_a_scene_that_diverges_when_run_still_checks(folder: Path) -> None:
    assert process("check", "absurd.yaml", cwd=folder).code == 0
