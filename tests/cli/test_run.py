"""`graphrun run`: what it takes, what it says, and how it ends."""

from __future__ import annotations

import re
import signal
import time
from contextlib import closing
from pathlib import Path

import pytest

from graphengine.cli.run import _signals
from graphengine.devices.dry_world import DryWorld
from graphengine.messages.endpoints import QoS
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests.cli.harness import ROOT, Graphrun, live, process
from tests.waiting import eventually

SUMMARY = re.compile(
    r"(\d+) ticks?, ([\d.]+) s of simulation in [\d.]+ s \(x[\d.]+\), [\d.]+ ms a tick, (\d+) messages?\n\Z"
)
STATUS = re.compile(
    r"t \d+\.\d\d s  x[\d.]+  \d+ late  \d+ messages/s  \d+ subscribers?  \d+ dropped  [\d.]+ ms a tick"
)
MEMORY = ("--transport", "memory")


def ticks(said: str) -> int:
    found = SUMMARY.search(said)
    assert found, f"no summary at the end of {said!r}"
    return int(found[1])


# What is run


def test_a_scene_that_ships_runs_by_its_name(graphrun: Graphrun) -> None:
    result = graphrun("run", "dd100_flat", "--for", "500ms", *MEMORY)
    assert (result.code, result.out, ticks(result.err)) == (0, "", 30)
    assert result.err.startswith("dd100_flat.yaml: 60 Hz, memory\n")
    assert max(map(len, result.err.splitlines())) <= 80
    explained = graphrun("run", "dd100_flat", "--for", "100ms", "--verbose", *MEMORY).err
    assert "dd100_flat.yaml: 4 graphs\nmemory: nothing leaves this process\n" in explained


def test_the_kind_of_rays_is_printed_if_there_is_a_lidar(graphrun: Graphrun, project: Path) -> None:
    result = graphrun("run", "dd100_flat", "--for", "100ms", "--rays", "mujoco", "--verbose", *MEMORY)
    assert "\nrays mujoco\n" in result.err
    (project / "bare.yaml").write_text("scene: bare\nworld: worlds/flat_grid.xml\n", encoding="utf-8")
    assert "rays" not in graphrun("run", "bare.yaml", "--for", "100ms", "--verbose", *MEMORY).err


def test_a_graph_that_asks_for_no_prims_runs_alone(graphrun: Graphrun, project: Path) -> None:
    result = graphrun("run", "mine.yaml", "--for", "1", *MEMORY)
    assert (result.code, ticks(result.err)) == (0, 60)
    assert result.err.startswith("mine.yaml: 60 Hz, memory")


def test_a_graph_runs_in_the_scene_that_is_given(graphrun: Graphrun) -> None:
    result = graphrun("run", "dd100/cmd_vel", "--scene", "dd100_flat", "--for", "1s", *MEMORY)
    assert (result.code, ticks(result.err)) == (0, 60)
    assert "cmd_vel.yaml: 60 Hz" in result.err


def test_a_graph_runs_in_the_scene_that_it_names(graphrun: Graphrun, project: Path) -> None:
    text = (ROOT / "graphs/dd100/cmd_vel.yaml").read_text(encoding="utf-8")
    (project / "drive.yaml").write_text(f"{text}scene: dd100_flat.yaml\n", encoding="utf-8")
    assert graphrun("run", "drive.yaml", "--for", "1s", *MEMORY).code == 0


def test_a_graph_with_prim_paths_gets_the_advice_to_name_a_scene(graphrun: Graphrun) -> None:
    result = graphrun("run", "dd100/cmd_vel", *MEMORY, code=2, out="")
    assert result.err.endswith("cmd_vel.yaml uses prims of a scene; give the scene with --scene\n")


def test_a_file_with_errors_does_not_run(graphrun: Graphrun, project: Path) -> None:
    broken = (project / "mine.yaml").read_text(encoding="utf-8").replace("Clock.execIn", "Clok.execIn")
    (project / "mine.yaml").write_text(broken, encoding="utf-8")
    result = graphrun("run", "mine.yaml", *MEMORY, code=1, out="")
    assert result.err.startswith("mine.yaml:10:18: error G203: no node 'Clok'\n")
    assert "did you mean 'Clock'?" in result.err


def test_warnings_are_printed_and_do_not_prevent_a_run(graphrun: Graphrun) -> None:
    result = graphrun("run", "tutorial/flat_grid", "--for", "100ms", *MEMORY)
    assert (result.code, ticks(result.err)) == (0, 6)
    assert "warning W201" in result.err
    assert "note N" not in result.err


# How long, how fast


@pytest.mark.parametrize(
    ("text", "expected"),
    [("2", 120), ("2s", 120), ("0.5", 30), (".5s", 30), ("250ms", 15), ("0.05min", 180), ("0", 0), ("10ms", 1)],
)
def test_time_is_simulation_time_in_several_units(graphrun: Graphrun, project: Path, text: str, expected: int) -> None:
    assert ticks(graphrun("run", "mine.yaml", "--for", text, *MEMORY).err) == expected


@pytest.mark.parametrize("rate", ["max", "realtime", "1", "5", "0.5"])
def test_the_rate_changes_the_pace_and_not_the_number_of_ticks(graphrun: Graphrun, project: Path, rate: str) -> None:
    result = graphrun("run", "mine.yaml", "--for", "100ms", "--rate", rate, *MEMORY)
    assert (result.code, ticks(result.err)) == (0, 6)


@pytest.mark.parametrize(("rate", "least"), [("realtime", 0.3), ("3", 0.1), ("0.5", 0.6)])
def test_a_paced_run_takes_no_less_than_its_time(graphrun: Graphrun, project: Path, rate: str, least: float) -> None:
    begun = time.monotonic()
    graphrun("run", "mine.yaml", "--for", "300ms", "--rate", rate, *MEMORY)
    assert time.monotonic() - begun >= least * 17 / 18  # the first tick is not waited for


@pytest.mark.parametrize(
    ("option", "value", "remedy"),
    [
        ("--for", "1h", "write 10, 10s, 500ms or 2min"),
        ("--for", "soon", "write 10, 10s, 500ms or 2min"),
        ("--for", "1e400", "write 10, 10s, 500ms or 2min"),
        ("--rate", "fast", "write realtime, max or a factor from 0.01 up"),
        ("--rate", "0", "write realtime, max or a factor from 0.01 up"),
        ("--rate", "-1", "write realtime, max or a factor from 0.01 up"),
        ("--rate", "nan", "write realtime, max or a factor from 0.01 up"),
        ("--rate", "1e-320", "write realtime, max or a factor from 0.01 up"),
        ("--transport", "zenoh", "choose from"),
        (
            "--simulation-interfaces",
            "mine",
            "write a namespace, as in --simulation-interfaces /one; write the scene or graph before this option",
        ),
        ("--simulation-interfaces", "/one/", "ends with '/'"),
        ("--seed", "x", "write a whole number"),
        ("--allow", "/nowhere", "no such folder"),
        ("--scene", "dd100_flatt", "did you mean 'dd100_flat'?"),
        ("--scene", "clock", "this is a graph file, not a scene"),
        ("--scene", "robots/dd100", "this is a robot file, not a scene"),
    ],
)
def test_an_invalid_value_of_an_option_is_refused_with_the_legal_values(
    graphrun: Graphrun, project: Path, option: str, value: str, remedy: str
) -> None:
    result = graphrun("run", "mine.yaml", option, value, code=2, out="")
    assert result.err.startswith("graphrun run: ")
    assert repr(value) in result.err or value in result.err
    assert remedy in result.err


# --set


def test_set_reaches_the_input_that_it_names(graphrun: Graphrun, project: Path) -> None:
    result = graphrun("topics", "mine.yaml", "--set", "Clock.topicName=time", "--format", "text")
    assert result.lines[1].startswith("/time ")


@pytest.mark.parametrize(
    "target",
    [
        "DiffController",
        "cmd_vel/DiffController",
        "dd100/cmd_vel/DiffController",
        "Diff*",
        "*/DiffController",
        "dd100/*/Diff*",
        "d?100/cmd_*/[D]iffController",
    ],
)
def test_set_accepts_globs_and_optional_outer_names(graphrun: Graphrun, target: str) -> None:
    result = graphrun("check", "dd100_flat", "--set", f"{target}.wheelRadius=0.098")
    assert "warning W201: wheelRadius is 0.098 m" in result.out
    assert "0.5 times the commanded speed" in result.out


def test_set_takes_values_as_yaml_has_them(graphrun: Graphrun) -> None:
    given = ["ArtController.jointNames=[a, b]", "ArtController.robotPath='5'", "*.timeout=1"]
    result = graphrun("show", "dd100/cmd_vel", *(word for text in given for word in ("--set", text)))
    assert {'    jointNames = ["a", "b"]', '    robotPath = "5"', "    timeout = 1.0 s"} <= set(result.lines)


@pytest.mark.parametrize(
    ("text", "complaint", "remedy"),
    [
        ("DiffControler.wheelRadius=1", "no node 'DiffControler'", "did you mean 'DiffController'?"),
        ("cmd_vle/Diff.wheelRadius=1", "no node 'cmd_vle/Diff'", "did you mean 'cmd_vel/DiffController'?"),
        ("left/right/Wheel.wheelRadius=1", "no node 'left/right/Wheel'", "nodes: cmd_vel/OnPlaybackTick, "),
        ("Arm*.wheelRadius=1", "no node 'Arm*'", "nodes: OnPlaybackTick, Context, "),
        ("Diff*.wheelRadus=1", "DifferentialController has no input 'wheelRadus'", "did you mean 'wheelRadius'?"),
        ("*.wheelRadus=1", "the nodes that it matches have no input 'wheelRadus'", "did you mean 'wheelRadius'?"),
        ("*Twist.speed=1", "ROS2SubscribeTwist has no input 'speed'", "inputs: context, nodeNamespace, "),
        ("wheelRadius=1", "write NODE.PORT=VALUE", ""),
        ("Diff.wheelRadius", "write NODE.PORT=VALUE", ""),
        ("", "write NODE.PORT=VALUE", ""),
        ("*.timeout=[1", "YAML syntax", ""),
    ],
)
def test_set_without_a_match_lists_the_nearest_names(
    graphrun: Graphrun, text: str, complaint: str, remedy: str
) -> None:
    result = graphrun("run", "dd100/cmd_vel", "--scene", "dd100_flat", "--set", text, *MEMORY, code=2, out="")
    assert result.err.startswith(f"graphrun run: --set {text.partition('=')[0]}")
    assert complaint in result.err
    assert remedy in result.err


@pytest.mark.parametrize("text", ["Clock.queueSize=-1", "Clock.queueSize=many", "*.queueSize=[1]"])
def test_an_invalid_value_of_set_is_reported_at_the_command_line(graphrun: Graphrun, project: Path, text: str) -> None:
    result = graphrun("run", "mine.yaml", "--set", text, *MEMORY, code=1)
    assert result.err.splitlines()[-1] == f"  given by --set {text.partition('=')[0]}"


def test_set_does_not_hide_the_errors_of_the_file(graphrun: Graphrun, project: Path) -> None:
    broken = (project / "mine.yaml").read_text(encoding="utf-8").replace("PublishClock", "PublishClok")
    (project / "mine.yaml").write_text(broken, encoding="utf-8")
    result = graphrun("check", "mine.yaml", "--set", "Clock.topicName=time", code=1)
    assert "unknown node type 'PublishClok'" in result.out


# --robot-state, --seed


def test_robot_state_is_published_on_request(graphrun: Graphrun) -> None:
    run = ("run", "dd100_flat", "--for", "100ms", "--verbose", *MEMORY)
    assert "4 graphs" in graphrun(*run).err
    assert "5 graphs" in graphrun(*run, "--robot-state").err


def test_robot_state_works_with_a_single_graph(graphrun: Graphrun) -> None:
    result = graphrun("topics", "dd100/joint_states", "--scene", "dd100_flat", "--robot-state")
    assert [line.split()[0] for line in result.lines if "robot_description" in line] == [
        "/dd100_0000/robot_description"
    ]


def test_robot_state_without_a_scene_is_refused(graphrun: Graphrun, project: Path) -> None:
    result = graphrun("run", "mine.yaml", "--robot-state", *MEMORY)
    assert (result.code, result.err) == (
        2,
        "graphrun run: a graph alone has no robots and no robot states; give a scene with --scene\n",
    )


@pytest.mark.parametrize("seed", ["0", "7", "-5", "999999999999999999999999"])
def test_any_whole_number_is_a_seed(graphrun: Graphrun, project: Path, seed: str) -> None:
    assert graphrun("run", "mine.yaml", "--for", "100ms", "--seed", seed, *MEMORY).code == 0


# How it ends


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_a_run_after_the_tick_with_the_summary_last(number: signal.Signals) -> None:
    with live("run", "dd100_flat", "--rate", "realtime", *MEMORY) as run:
        assert run.hear(lambda said: "60 Hz, memory" in said)
        code = run.stop(number)
        assert code == 0, run.said
        assert SUMMARY.search(run.said)


def test_a_run_under_nohup_outlives_its_terminal() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup leaves it to the program
    try:
        with _signals(session=None):  # type: ignore[arg-type]
            assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) != signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_takes_the_endpoints_off_the_network(number: signal.Signals, domain_id: int) -> None:
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with closing(DdsTransport(JoinOptions(Domain(domain_id, "LOCALHOST"), "peer"))) as peer:
        writer = peer.writer("/dd100_0000/cmd_vel", "geometry_msgs/msg/Twist", QoS())
        with live("run", "dd100_flat", "--transport", "dds", env=env) as run:
            assert run.hear(lambda said: f"domain {domain_id}" in said)
            assert eventually(lambda: writer.matched), "the robot's subscription was not found"
            assert run.stop(number) == 0, run.said
            assert SUMMARY.search(run.said)
            assert eventually(lambda: not writer.matched), "the robot's subscription is still there"


# What is shown meanwhile


def test_without_a_terminal_lines_are_plain(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.cli.console.Console.PLAIN", 0.0)
    result = graphrun("run", "dd100_flat", "--for", "100ms", *MEMORY)
    lines = result.err.splitlines()
    assert [bool(STATUS.fullmatch(line)) for line in lines] == [False, *[True] * 6, False, False]


def test_messages_that_were_dropped_are_counted_in_the_end(
    graphrun: Graphrun, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(LiveNetwork, "malformed", {"/b": 2, "/a": 1})
    monkeypatch.setattr(LiveNetwork, "overwritten", {"/b": 4})
    monkeypatch.setattr(LiveNetwork, "given_up", {"/c": 3})
    result = graphrun("run", "mine.yaml", "--for", "100ms", *MEMORY)
    assert result.err.splitlines()[1:-2] == [
        "malformed and dropped: 1 message of /a",
        "malformed and dropped: 2 messages of /b",
        "overwritten before a tick read them: 4 messages of /b",
        "given up on a reader that did not keep up: 3 messages of /c",
    ]


def test_late_images_are_reported_at_once_and_counted_at_the_end(
    graphrun: Graphrun, project: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def step(world: DryWorld) -> None:
        world.dropped_pictures["/robot/camera"] = world.dropped_pictures.get("/robot/camera", 0) + 1

    monkeypatch.setattr(DryWorld, "step", step)
    result = graphrun("run", "mine.yaml", "--for", "100ms", *MEMORY)
    _, warning, remedy, count, *_ = result.err.splitlines()
    assert warning == "warning: /robot/camera: an image came too late and was dropped"
    assert remedy.startswith("  rendering does not keep up")
    assert count == "came too late and dropped: 6 images of /robot/camera"
    assert ticks(result.err) == 6


def test_without_a_terminal_a_short_run_without_subscribers_prints_three_lines() -> None:
    result = process("run", "dd100_flat", "--for", "1s", "--rays", "mujoco", *MEMORY, code=0, out="")
    assert not re.search(r"[\r\x1b]", result.err)
    assert len(result.err.splitlines()) == 3
    assert result.err.splitlines()[1].startswith("few messages: topics without subscribers send only")
    assert ticks(result.err) == 60


def test_a_profile_lists_nodes_in_order_of_computing_time(graphrun: Graphrun) -> None:
    result = graphrun("run", "dd100_flat", "--for", "1s", "--profile", *MEMORY)
    header, *rows, last = result.err.splitlines()[3:]
    assert header.split() == ["node", "type", "runs", "fired", "us", "a", "run", "share"]
    assert last == "in 6 ticks of 60"
    runs = {row.split()[0]: row.split()[2:4] for row in rows}
    assert runs["dd100/joint_states/OnPlaybackTick"] == ["6", "6"]
    shares = [float(row.split()[-2]) for row in rows]
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) == pytest.approx(100.0, abs=2.0)
