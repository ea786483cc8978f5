"""`graphrun ctl`: a run in a process of its own, and what is asked of it from another."""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from graphengine.cli import make_parser
from graphengine.runtime.commands import COMMANDS, parse
from tests.cli.harness import Graphrun, Live, Result, live
from tests.cli.screen import frames

MEMORY = ("--transport", "memory")
CUBE = '<robot name="cube"><link name="base_link"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" \
ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry><box size=".2 .2 .2"/></geometry></collision></link></robot>'


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The folder of the sockets; no run of others is in it."""
    with tempfile.TemporaryDirectory(prefix="graphrun-test-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield Path(folder) / "graphrun"


@contextlib.contextmanager
def paused(*arguments: str, **how: Any) -> Iterator[Live]:
    """A run that waits at time 0."""
    with live("run", *arguments, "--paused", **how) as run:
        assert run.hear(lambda said: " Hz, " in said)
        yield run


@pytest.fixture
def ctl(graphrun: Graphrun) -> Graphrun:
    def ask(*words: str, refused: str = "") -> Result:
        """Ask for something that is done, or is refused with some words."""
        result = graphrun("ctl", *words)
        assert (result.code, result.err) == (0, "") if not refused else result.code == 1, result
        assert refused in result.err
        return result

    return ask


def state(ctl: Graphrun) -> Any:
    return json.loads(ctl("state", "--json").out)


@pytest.mark.parametrize("command", ["move box 1 2", "state", "set A.b=1", "quit"])
@pytest.mark.parametrize("options", ["--run 16087", "--run 16087 --json", "--json"])
def test_the_options_stand_before_or_after_the_command(command: str, options: str) -> None:
    before, after = (
        make_parser("ctl").parse_args(["ctl", *words.split()])
        for words in (f"{options} {command}", f"{command} {options}")
    )
    assert (
        (before.run, before.json) == (after.run, after.json) == ("16087" if "run" in options else "", "json" in options)
    )


# A run in another process


def test_ctl_pauses_steps_and_plays_a_run(ctl: Graphrun) -> None:
    with paused("dd100_flat", "--rate", "realtime", *MEMORY) as run:
        name = f"dd100_flat (process {run.process.pid})"
        assert ctl("state").lines == [
            f"{name}: paused, t = 0.000 s, rate 1",
            "  dd100  /dd100_0000  at (0.00, 0.00) m, yaw 0 deg",
        ]
        assert ctl("step").lines == [f"{name}: paused, t = 0.017 s, rate 1"]
        assert ctl("step", "59").lines == [f"{name}: paused, t = 1.000 s, rate 1"]
        ctl("rate", "max")
        ctl("play")
        ctl("step", refused="error: the session is playing; pause it before running single ticks")
        assert state(ctl)["rate"] == "max"
        ctl("stop")
        ctl("pause", refused="a stopped session cannot pause")
        assert (state(ctl)["state"], state(ctl)["time"]) == ("stopped", 0.0)
        assert json.loads(ctl("quit", "--json").out) == {"run": "dd100_flat", "process": run.process.pid}
        assert run.stop(signal.SIGCONT) == 0
        assert " s of simulation in " in run.said.splitlines()[-1]


def test_a_run_goes_back_to_a_checkpoint(ctl: Graphrun) -> None:
    with paused("dd100_flat", "--rate", "realtime", *MEMORY):
        ctl("step", "30")
        ctl("checkpoint", "before")
        here = state(ctl)["robots"]
        ctl("move", "dd100", "3", "1")
        ctl("command", "dd100", "--velocities", "front_left_wheel_joint=5")
        ctl(
            "command",
            "dd100",
            "--velocities",
            "front_lift_wheel_joint=5",
            refused="did you mean 'front_left_wheel_joint'",
        )
        ctl("step", "30")
        assert state(ctl)["robots"] != here
        ctl("reset-robot", "dd100", "--at", "1,2,0.025")
        assert state(ctl)["robots"][0]["position"] == pytest.approx([1.0, 2.0, 0.025])
        ctl("restore", "before")
        assert (state(ctl)["time"], state(ctl)["robots"]) == (0.5, here)
        ctl("restore", "after", refused="no checkpoint 'after'")


def test_robots_are_spawned_moved_and_deleted(ctl: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cube.urdf").write_text(CUBE, encoding="utf-8")
    (tmp_path / "cube.yaml").write_text("robot: cube\nurdf: cube.urdf\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with paused("dd100_flat", "--allow", str(tmp_path), *MEMORY):
        second = ctl(
            "spawn", "second", "robots/dd100.yaml", "--at", "-1,2,0.03", "--yaw", "-90deg", "--namespace", "two"
        )
        assert second.lines[1:] == [
            "  dd100   /dd100_0000  at (0.00, 0.00) m, yaw 0 deg",
            "  second  /two         at (-1.00, 2.00) m, yaw -90 deg  spawned",
        ]
        ctl("spawn", "cube", "cube.yaml", "--at", "3,0,1")
        ctl("move", "cube", "-3", "4", "--rpy", "0,0,180deg", "--linear", "-1,0,0")
        cube = state(ctl)["robots"][2]
        assert cube["position"] == [-3.0, 4.0, 1.0]
        ctl("push", "cube", "--impulse", "0,1,0")
        ctl("push", "cube", "--force", "0,0,9.81", "--for", "200ms", "--at", "-3,4,1")
        ctl("step", "6")
        x, y, z = state(ctl)["robots"][2]["position"]
        assert x == pytest.approx(-3.1, abs=0.02)
        assert y == pytest.approx(4.1, abs=0.02)
        assert z == pytest.approx(1.0, abs=0.02)  # its weight is held
        ctl("delete", "second")
        ctl("delete", "second", refused="no robot 'second'")
        ctl("set", "DiffController.maxLinearSpeed=0.5")
        ctl("set", "DiffController.maxLinearSpeed=fast", refused="is a double: expected a number, got 'fast'")
        ctl("reset", "--scope", "state", "--scope", "time")
        assert state(ctl)["robots"][1]["position"] == pytest.approx([3.0, 0.0, 1.0])
        ctl("reset")
        assert [robot["name"] for robot in state(ctl)["robots"]] == ["dd100"]


def test_the_movable_entities_are_listed(ctl: Graphrun) -> None:
    with paused("dd100_warehouse", *MEMORY):
        objects = ctl("state").lines[-1]
        assert objects.startswith("  objects: ")
        assert "box_01" in objects
        ctl("move", "box_01", "-3", "2", "3")
        ctl("push", "box_1", "--impulse", "1,0,0", refused="did you mean 'box_01'")


def test_spawning_into_an_object_warns_and_moving_into_one_is_refused(graphrun: Graphrun) -> None:
    with paused("dd100_flat", *MEMORY) as run:
        done = graphrun("ctl", "spawn", "late", "robots/dd100.yaml", "--at", "0,3,-0.07", "--namespace", "late")
        into_ground, _, _ = done.err.partition("\n")
        assert into_ground.startswith("warning: late is 0.0")
        assert " m deep in floor: physics pushes them apart at once" in into_ground
        assert done.lines[-1].endswith("spawned")
        assert graphrun("ctl", "why", "late", code=0).lines[0] == "no tick has run yet: the simulation is paused"
        assert graphrun("ctl", "clearance", "late", "0.2,0", code=0).lines == ["dd100  overlaps"]
        assert graphrun("ctl", "clearance", "late", "5,0", code=0).lines == ["nothing stands there"]
        refused = graphrun("ctl", "move", "late", "0.2", "0", "0.03")
        assert refused.code != 0
        assert "late would be 0." in refused.err
        assert " m deep in dd100: nothing was changed" in refused.err
        done = graphrun("ctl", "move", "late", "0.2", "0", "0.03", "--force", code=0)
        assert done.err.startswith("warning: late is 0.")
        assert " m deep in dd100" in done.err
        assert graphrun("ctl", "move", "late", "5", "0", "0.03").err == ""
        assert run.hear(lambda said: into_ground in said and " m deep in dd100" in said)


def test_a_command_that_is_refused_is_not_blamed_on_the_scenes_file(ctl: Graphrun) -> None:
    with paused("dd100_flat", *MEMORY):
        for name, use, words in (
            ("dd100", "robots/dd100.yaml", "'dd100' is taken"),
            ("a/b", "x.yaml", "is not a valid name"),
        ):
            assert "dd100_flat.yaml" not in ctl("spawn", name, use, refused=words).err
        ctl("delete", "dd100")
        refused = ctl("spawn", "dd100", "nothing.yaml", refused="error S101: no file 'nothing.yaml'").err
        assert "dd100_flat.yaml" not in refused


def test_the_run_decides_which_files_it_reads(ctl: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cube.urdf").write_text(CUBE, encoding="utf-8")
    (tmp_path / "cube.yaml").write_text("robot: cube\nurdf: cube.urdf\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with paused("dd100_flat", *MEMORY):
        ctl("spawn", "cube", "cube.yaml", refused=f"--allow {tmp_path}")
        ctl("spawn", "cube", "/etc/passwd", refused="lies outside the folder")
        ctl("spawn", "cube", "nothing.yaml", refused="no file 'nothing.yaml'")
        assert len(state(ctl)["robots"]) == 1


def test_a_run_over_dds_is_asked_in_the_same_way(ctl: Graphrun, domain_id: int) -> None:
    env = {"ROS_DOMAIN_ID": str(domain_id), "XDG_RUNTIME_DIR": os.environ["XDG_RUNTIME_DIR"]}
    with paused("dd100_flat", "--transport", "dds", env=env) as run:
        ctl("step", "3")
        assert state(ctl)["tick"] == 3
        assert run.stop(signal.SIGINT) == 0
        assert "3 ticks, 0.050 s of simulation" in run.said


# Which run


def test_ctl_without_a_run_is_refused(ctl: Graphrun) -> None:
    ctl("state", refused="error: no run to control")


def test_one_of_several_runs_is_chosen_by_name(ctl: Graphrun, graphrun: Graphrun, project: Path) -> None:
    with paused("mine.yaml", *MEMORY, cwd=project) as one, paused("dd100_flat", *MEMORY) as other:
        asked = graphrun("ctl", "state", code=2)
        assert asked.err.splitlines() == [
            "graphrun ctl: there are 2 runs; choose one",
            f"  --run {other.process.pid}   dd100_flat",
            f"  --run {one.process.pid}   mine",
        ]
        assert ctl("step", "--run", "mine").out.startswith(f"mine (process {one.process.pid}): paused, t = 0.017 s")
        assert ctl("state", "--run", str(other.process.pid)).out.startswith("dd100_flat ")


def test_the_entry_of_a_killed_run_is_removed_at_the_next_lookup(ctl: Graphrun, runtime: Path, project: Path) -> None:
    with paused("mine.yaml", *MEMORY, cwd=project) as run:
        run.stop(signal.SIGKILL)
    assert [path.name for path in runtime.iterdir()] == [f"mine.{run.process.pid}"]
    ctl("state", refused="no run to control")
    assert list(runtime.iterdir()) == []


def test_a_run_can_be_closed_to_others(ctl: Graphrun, project: Path) -> None:
    with live("run", "mine.yaml", "--rate", "realtime", "--no-control", *MEMORY, cwd=project) as run:
        assert run.hear(lambda said: " Hz, " in said)
        ctl("state", refused="no run to control")
        assert run.stop(signal.SIGINT) == 0


def test_a_run_without_a_control_channel_continues_with_a_warning(
    graphrun: Graphrun, project: Path, runtime: Path
) -> None:
    runtime.write_bytes(b"in the way")
    result = graphrun("run", "mine.yaml", "--for", "1", *MEMORY, code=0)
    assert result.err.startswith(f"warning: graphrun ctl cannot reach this run: {runtime}: must be a folder")
    assert "60 ticks" in result.err


# A run that is paused


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_run_that_is_paused(number: signal.Signals, project: Path, runtime: Path) -> None:
    with paused("mine.yaml", "--for", "10", *MEMORY, cwd=project) as run:
        assert run.stop(number) == 0
    assert run.said.splitlines()[-1].startswith("0 ticks, 0.000 s of simulation in ")
    assert list(runtime.iterdir()) == []


def test_the_time_of_a_run_is_its_simulation_time(ctl: Graphrun, project: Path) -> None:
    with paused("mine.yaml", "--for", "1s", *MEMORY, cwd=project) as run:
        ctl("step", "30")
        ctl("reset")
        ctl("step", "29")
        assert state(ctl)["tick"] == 29
        assert ctl("step").out == ""  # it was the last
        assert run.stop(signal.SIGCONT) == 0
    assert run.said.splitlines()[-1].startswith("60 ticks, 1.000 s of simulation in ")


def test_the_topics_of_a_run_are_listed_without_its_services(ctl: Graphrun, project: Path) -> None:
    with paused("mine.yaml", *MEMORY, cwd=project):
        assert ctl("topics").out == "/clock\n"
        assert json.loads(ctl("topics", "--json").out) == {"topics": {"/clock": "rosgraph_msgs/msg/Clock"}}
    with paused("dd100_flat", *MEMORY):
        assert "/dd100_0000/cmd_vel" in ctl("topics").lines


def test_a_terminal_shows_that_a_run_is_paused(project: Path) -> None:
    with paused("mine.yaml", *MEMORY, cwd=project, columns=100, env={"TERM": "xterm"}) as run:
        assert run.hear(lambda said: "t 0.00 s  paused  0 late" in " ".join(frames(said)))


# The command line


@pytest.mark.parametrize(
    ("words", "legal"),
    [
        (["rate", "0"], "is not a rate; write realtime, max or a factor"),
        (["rate", "nan"], "is not a rate"),
        (["rate", "-1"], "'-1' is not a rate"),
        (["step", "x"], "'x': write a whole number"),
        (["move", "a", "x", "1"], "'x': write a number"),
        (["move", "a", "inf", "1"], "'inf': write a number"),
        (["move", "a", "1", "2", "--yaw", "90grad"], "'90grad' is not an angle; write"),
        (["move", "a", "1", "2", "--yaw", "1", "--rpy", "0,0,1"], "not allowed with"),
        (["spawn", "a", "b.yaml", "--at", "-1"], "'-1': write 2 or 3 numbers separated by commas"),
        (["fault", "--silent"], "one of the arguments --sensor --topic is required"),
        (["push", "a"], "one of the arguments --force --impulse is required"),
        (["push", "a", "--force", "1,2"], "'1,2': write 3 numbers"),
        (["push", "a", "--force", "1,2,3", "--for", "soon"], "'soon' is not a time"),
        (["push", "a", "--force", "1,2,3", "--for", "-2ms"], "'-2ms' is not a time"),
        (["command", "a", "--velocities", "5"], "'5' is not a target; write JOINT=NUMBER"),
        (["command", "a", "--velocities", "b=fast"], "'fast': write a number"),
        (["reset", "--scope", "world"], "invalid choice"),
        (["fly"], "no command 'fly'"),
        ([], "COMMAND is missing"),
    ],
)
def test_an_invalid_command_line_is_reported(graphrun: Graphrun, words: list[str], legal: str) -> None:
    result = graphrun("ctl", *words, code=2)
    assert legal in result.err


@pytest.mark.parametrize(
    ("words", "arguments"),
    [
        (["step"], {"ticks": 1}),
        (["reset"], {}),
        (["reset", "--scope", "time", "--scope", "state"], {"scope": ["time", "state"]}),
        (["rate", "realtime"], {"factor": 1.0}),
        (["rate", "max"], {"factor": "max"}),
        (
            ["fault", "--sensor", "a/lidar", "--silent", "--for", "2s"],
            {"sensor": "a/lidar", "silent": True, "duration": 2.0},
        ),
        (
            ["fault", "--topic", "/odom", "--delay", "300ms", "--dropout", "0.2"],
            {"topic": "/odom", "delay": 0.3, "dropout": 0.2},
        ),
        (["mend"], {}),
        (["push", "a", "--impulse", "-1,0,.5"], {"entity": "a", "impulse": (-1.0, 0.0, 0.5)}),
        (
            ["command", "a", "--positions", "b=-1", "c=90deg", "--efforts", "d=.5"],
            {"robot": "a", "positions": {"b": -1.0, "c": math.pi / 2}, "efforts": {"d": 0.5}},
        ),
        (["reset-robot", "a"], {"robot": "a", "joints": {}, "force": False}),
        (
            ["reset-robot", "a", "--at", "-1,2,0.5", "--joints", "b=90deg", "--keyframe", "home", "--force"],
            {
                "robot": "a",
                "position": (-1.0, 2.0, 0.5),
                "joints": {"b": math.pi / 2},
                "keyframe": "home",
                "force": True,
            },
        ),
        (["move", "a", "-1", "-2e-1"], {"entity": "a", "position": [-1.0, -0.2]}),
        (["move", "a", "--angular", "-.5,0,0"], {"entity": "a", "angular": (-0.5, 0.0, 0.0)}),
        (["move", "a", "1", "2", "--odometry-jumps"], {"entity": "a", "position": [1.0, 2.0], "odometry": "jumps"}),
        (["why", "a"], {"robot": "a"}),
        (["clearance", "a", "1,2"], {"entity": "a", "position": (1.0, 2.0), "margin": 0.0}),
        (
            ["move", "a", "1", "2", "3", "--quaternion", "0,0,1,0"],
            {"entity": "a", "position": [1.0, 2.0, 3.0], "orientation": {"quaternion_xyzw": (0.0, 0.0, 1.0, 0.0)}},
        ),
    ],
)
def test_the_written_file_has_the_requested_content(words: list[str], arguments: dict[str, Any]) -> None:
    given = make_parser("ctl").parse_args(["ctl", *words])
    asked = given.arguments(given)
    assert {key: value for key, value in asked.items() if value is not None} == arguments
    parse(words[0], arguments)


def test_every_command_of_the_table_has_help(graphrun: Graphrun) -> None:
    told = graphrun("ctl", "--help").out
    for name in COMMANDS:
        assert re.search(rf"\n    {name}\s", told)
        assert graphrun("ctl", name, "--help").out.startswith(f"usage: graphrun ctl {name} ")
