"""`graphrun nav2 goals` against a Nav2 that answers as it is told, and with a run that knows the true pose."""

from __future__ import annotations

import contextlib
import itertools
import signal
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final
from xml.etree import ElementTree

import pytest

from graphengine.bringup.navigation.goal_list import NavigationGoal
from graphengine.bringup.navigation.navigator import Navigator
from graphengine.control.client import Client, find
from graphengine.format.errors import TransportError
from graphengine.ros.action_caller import ActionCaller
from graphengine.ros.cli_subscription import SimulationClock
from graphengine.ros.domain import Domain
from graphengine.ros.transport import JoinOptions
from graphengine.ros.transports.dds.dds import DdsTransport
from tests import nav2_peer
from tests.cli.harness import Graphrun, Live, live
from tests.nav2_peer import Behaviour, Localization, Nav2Peer
from tests.waiting import PATIENCE, eventually

NAMESPACE = "/dd100_0000"
RANGE: Final = "LOCALHOST"
Nav2 = Callable[..., Nav2Peer]


@pytest.fixture(autouse=True)
def sockets(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """The folder of the sockets; no run of others is in it."""
    with tempfile.TemporaryDirectory(prefix="graphrun-test-") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield folder


@pytest.fixture
def peer(domain_id: int) -> Iterator[DdsTransport]:
    with contextlib.closing(
        DdsTransport(JoinOptions(Domain(domain_id, RANGE), "bt_navigator", NAMESPACE))
    ) as transport:
        yield transport


@pytest.fixture
def nav2(peer: DdsTransport) -> Iterator[Nav2]:
    with contextlib.ExitStack() as stack:

        def start(*behaviours: Behaviour, namespace: str = NAMESPACE) -> Nav2Peer:
            clock = SimulationClock(peer)
            made = Nav2Peer(peer, namespace, behaviours, lambda: clock() * 1e-9)
            stack.callback(made.close)
            return made

        yield start


@pytest.fixture
def goals(graphrun: Graphrun, monkeypatch: pytest.MonkeyPatch) -> Graphrun:
    """`graphrun nav2 goals` in this process; without a clock, it waits only shortly for one."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", RANGE)
    monkeypatch.setattr("graphengine.cli.nav2.goals.CLOCK_PATIENCE", 0.5)
    nav2_peer.watch_feedback(monkeypatch)
    return lambda *given, **ended: graphrun("nav2", "goals", *given, "--transport", "dds", **ended)


@contextlib.contextmanager
def running(domain_id: int, *options: str) -> Iterator[Live]:
    """A run of dd100_flat on the network."""
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": RANGE}
    with live("run", "dd100_flat", "--transport", "dds", *options, env=env) as run:
        assert run.hear(lambda said: " Hz, " in said)
        yield run


def ignore(server: Nav2Peer, goal: bytes) -> None:
    """Lose the answer to the goal."""
    server._requests["send_goal"].pop(0)


def cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.split("  ") if cell.strip()]


# Goals of the command line and of files


def test_goals_are_sent_one_after_another_in_the_frame_of_the_map(goals: Graphrun, nav2: Nav2) -> None:
    server = nav2(nav2_peer.reach)
    done = goals("1.5 -2 90deg", "3,4", code=0)
    sent = [message.pose for message in server.messages]
    assert [(pose.pose.position.x, pose.pose.position.y) for pose in sent] == [(1.5, -2.0), (3.0, 4.0)]
    assert [pose.header.frame_id for pose in sent] == ["map", "map"]
    assert sent[0].pose.orientation.z == pytest.approx(0.5**0.5)
    assert (sent[1].pose.orientation.z, sent[1].pose.orientation.w) == (0.0, 1.0)
    assert cells(done.lines[1])[:2] == ["1.5 -2 1.571", "reached"]
    assert cells(done.lines[1])[4:] == ["0.050 m", "-", "2", "-"]
    assert done.lines[-1] == "2 of 2 goals reached"
    assert "true poses are unknown: no run to control" in done.err
    assert "no messages on /clock: times are wall times" in done.err


def test_goals_of_a_file_have_names(goals: Graphrun, nav2: Nav2, tmp_path: Path) -> None:
    server = nav2(nav2_peer.reach)
    file = tmp_path / "goals.yaml"
    file.write_text("format: 1\ngoals:\n  - {x: 1, y: 2.5, yaw: 0.5, name: dock}\n  - {x: -1, y: 0}\n", "utf-8")
    done = goals(str(file), code=0)
    assert len(server.messages) == 2
    assert [cells(line)[0] for line in done.lines[1:3]] == ["dock", "-1 0 0"]


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("goals: []\n", "goals"),
        ("goals:\n  - {x: 1}\n", "goals.yaml:2:5: error G107: missing key 'y'"),
        ("goals:\n  - {x: 1, y: east}\n", "goals.yaml:2:15: error G108"),
        ("goals:\n  - {x: 1, y: 2, jaw: 1}\n", "unknown key 'jaw'"),
        ("format: 2\ngoals:\n  - {x: 1, y: 2}\n", "format 2 is not supported"),
        ("goals:\n  - {x: .nan, y: 2}\n", "error"),
    ],
)
def test_errors_in_a_file_have_their_place(goals: Graphrun, tmp_path: Path, text: str, error: str) -> None:
    (tmp_path / "goals.yaml").write_text(text, "utf-8")
    assert error in goals(str(tmp_path / "goals.yaml"), code=1, out="").err


@pytest.mark.parametrize("given", ["1", "1 2 3 4", "1 east 0", "1 2 90grad", "1 nan"])
def test_words_that_are_no_goal_are_refused(goals: Graphrun, given: str) -> None:
    assert "write a goal as 'X Y YAW'" in goals(given, code=2, out="").err


def test_a_missing_file_is_reported(goals: Graphrun) -> None:
    assert "nowhere.yaml: no such file" in goals("nowhere.yaml", code=2, out="").err


# What becomes of goals


def test_after_an_aborted_goal_the_next_is_sent_and_its_error_code_is_named(
    goals: Graphrun, nav2: Nav2, tmp_path: Path
) -> None:
    nav2(nav2_peer.abort, nav2_peer.reach)
    done = goals("1 2", "3 4", "--junit", str(tmp_path / "out" / "junit.xml"), code=1)
    assert cells(done.lines[1])[-1] == "NO_VALID_PATH (208): no way"
    assert done.lines[-1] == "1 of 2 goals reached"
    suite = ElementTree.parse(tmp_path / "out" / "junit.xml").getroot()
    assert (suite.get("name"), suite.get("tests"), suite.get("failures")) == (f"nav2 goals {NAMESPACE}", "2", "1")
    first, second = suite.findall("testcase")
    assert (first.get("name"), first.find("failure").get("message")) == (  # type: ignore[union-attr]
        "1 2 0",
        "aborted: NO_VALID_PATH (208): no way",
    )
    assert second.find("failure") is None
    properties = {one.get("name"): one.get("value") for one in second.iter("property")}
    assert properties["error_m"] == "0.05"
    assert properties["recoveries"] == "2"


def test_a_goal_is_sent_again_until_nav2_is_active(goals: Graphrun, nav2: Nav2) -> None:
    server = nav2(nav2_peer.reject, nav2_peer.reject, nav2_peer.reach)
    done = goals("1 2", code=0)
    assert len(server.messages) == 3
    assert done.err.count(f"{NAMESPACE}/navigate_to_pose rejects the goal: waiting until Nav2 is active") == 1


def test_the_wait_for_an_inactive_nav2_ends_after_its_limit(goals: Graphrun, nav2: Nav2) -> None:
    nav2(nav2_peer.reject)
    done = goals("1 2", "--wait", "1s", code=1)
    assert cells(done.lines[1])[1] == "rejected"


def test_a_goal_that_takes_too_long_is_canceled(goals: Graphrun, nav2: Nav2) -> None:
    server = nav2(nav2_peer.dawdle_until_canceled, nav2_peer.reach)
    done = goals("1 2", "3 4", "--patience", "500ms", code=1)
    assert server.cancelled == server.goals[:1]
    assert [cells(line)[1] for line in done.lines[1:3]] == ["timed out", "reached"]
    assert cells(done.lines[1])[-1] == "not reached within 0.5 s"


def test_a_lost_server_ends_all_goals(
    goals: Graphrun, nav2: Nav2, peer: DdsTransport, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.navigator.LOST", 0.5)

    def die(server: Nav2Peer, goal: bytes) -> None:
        nav2_peer.dawdle(server, goal)
        peer.close()

    nav2(die)
    done = goals("1 2", "3 4", code=1)
    assert [cells(line)[1] for line in done.lines[1:3]] == ["server lost", "not sent"]


def test_a_result_that_cannot_be_decoded_fails_its_goal_alone(
    goals: Graphrun, nav2: Nav2, monkeypatch: pytest.MonkeyPatch
) -> None:
    follow = Navigator._follow

    def garbled(navigator: Navigator, goal: NavigationGoal, *rest: Any) -> tuple[str, str]:
        followed = follow(navigator, goal, *rest)
        if goal.x == 1.0:
            raise TransportError("the response is cut off")
        return followed

    monkeypatch.setattr(Navigator, "_follow", garbled)
    nav2(nav2_peer.reach)
    done = goals("1 2", "3 4", code=1)
    assert [cells(line)[1] for line in done.lines[1:3]] == ["failed", "reached"]
    assert cells(done.lines[1])[-1] == "the response is cut off"


def test_a_goal_whose_answer_is_lost_is_sent_once_more(
    goals: Graphrun, nav2: Nav2, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.navigator.ANSWER", 0.5)
    server = nav2(ignore, nav2_peer.reach)
    assert cells(goals("1 2", code=0).lines[1])[1] == "reached"
    assert len(server.messages) == 2


def test_a_goal_whose_answer_is_lost_twice_is_canceled_and_the_next_is_sent(
    goals: Graphrun, nav2: Nav2, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.navigator.ANSWER", 0.5)
    server = nav2(ignore, ignore, nav2_peer.reach)
    done = goals("1 2", "3 4", code=1)
    assert [cells(line)[1] for line in done.lines[1:3]] == ["no answer", "reached"]
    assert server.cancelled == server.goals[:2]


def test_a_goal_is_canceled_when_time_stands_still(
    goals: Graphrun, nav2: Nav2, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.navigator.STANDSTILL", 0.5)
    monkeypatch.setattr("graphengine.cli.nav2.goals._other_clock", lambda truth: lambda: 7.0)
    server = nav2(nav2_peer.dawdle_until_canceled)
    done = goals("1 2", "3 4", code=1)
    assert [cells(line)[1] for line in done.lines[1:3]] == ["time stands still", "not sent"]
    assert server.cancelled == server.goals


def test_a_server_is_waited_for_before_the_first_goal(
    goals: Graphrun, nav2: Nav2, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.navigator.LOST", 0.0)
    looks = itertools.count()
    ready = ActionCaller.ready
    matched = property(lambda caller: next(looks) > 5 and ready.__get__(caller))
    monkeypatch.setattr(ActionCaller, "ready", matched)
    nav2(nav2_peer.reach)
    goals("1 2", code=0)


def test_without_nav2_the_error_says_where_it_was_looked_for(goals: Graphrun, domain_id: int) -> None:
    done = goals("1 2", "--wait", "0s", code=1, out="")
    assert done.err.startswith("error: no action navigate_to_pose\nis Nav2 running in this domain?\nsearched domain ")


def test_one_of_several_robots_is_chosen_by_its_namespace(goals: Graphrun, nav2: Nav2) -> None:
    first, second = nav2(nav2_peer.reach, namespace="/a"), nav2(nav2_peer.reach, namespace="/b")
    done = goals("1 2", code=1, out="")
    assert "there are 2 robots with Nav2\nchoose one with --namespace: /a, /b" in done.err
    goals("1 2", "--namespace", "b", code=0)
    assert (len(first.messages), len(second.messages)) == (0, 1)
    assert "namespaces with Nav2: /a, /b" in goals("1 2", "--namespace", "c", "--wait", "0s", code=1).err


def test_ctrl_c_cancels_the_goal_and_prints_the_table(nav2: Nav2, domain_id: int) -> None:
    server = nav2(nav2_peer.dawdle_until_canceled)
    env = {"ROS_DOMAIN_ID": str(domain_id), "ROS_AUTOMATIC_DISCOVERY_RANGE": RANGE}
    with live("nav2", "goals", "1 2", "3 4", "--transport", "dds", env=env, out=True) as sending:
        assert eventually(lambda: server.asked)
        sending.process.send_signal(signal.SIGINT)
        assert sending.hear(lambda said: said.endswith("0 of 2 goals reached\n"))
        assert sending.process.wait(PATIENCE) == 1
    assert server.cancelled == server.goals
    assert "by Ctrl-C" in sending.said


# The true pose of a run


def test_errors_are_measured_against_the_true_pose_of_the_run(goals: Graphrun, nav2: Nav2, domain_id: int) -> None:
    with running(domain_id):
        server = nav2(nav2_peer.reach)
        assert eventually(lambda: server.now() > 0.0)
        done = goals("0.3 0.4", code=0)
    row = cells(done.lines[1])
    assert row[:2] == ["0.3 0.4 0", "reached"]
    assert row[4:] == ["0.050 m", "0.500 m, 0.0 deg", "2", "mean 0.488 m, max 0.488 m"]


def test_a_localization_gets_the_true_pose_before_the_first_goal(
    goals: Graphrun, nav2: Nav2, peer: DdsTransport, domain_id: int
) -> None:
    localization = Localization(peer, NAMESPACE)
    with running(domain_id, "--set", "DiffController.maxLinearSpeed=1.0"):
        nav2(nav2_peer.reach)
        done = goals("1 2", code=0)
        taken = localization.taken[-1]
        assert taken.header.frame_id == "map"
        assert taken.pose.pose.position.x == pytest.approx(0.0, abs=1e-3)
        assert taken.pose.covariance[0] == pytest.approx(0.0025)
        assert f"publishing the true pose on {NAMESPACE}/initialpose" in done.err
        localization.taken.clear()
        goals("1 2", "--no-initial-pose", code=0)
        assert localization.taken == []


def test_the_end_of_a_run_ends_all_goals(goals: Graphrun, nav2: Nav2, domain_id: int) -> None:
    with running(domain_id) as run:

        def end_the_run(server: Nav2Peer, goal: bytes) -> None:
            nav2_peer.dawdle(server, goal)
            run.process.send_signal(signal.SIGINT)
            if server.wait(lambda: goal in server.cancelled):
                server.answer_cancel()
                server.answer_result(5)

        nav2(end_the_run)
        done = goals("1 2", "3 4", code=1)
    assert [cells(line)[1] for line in done.lines[1:3]] == ["run ended", "not sent"]


def test_a_run_without_the_robot_leaves_its_true_pose_unknown(goals: Graphrun, nav2: Nav2, domain_id: int) -> None:
    with running(domain_id):
        nav2(nav2_peer.reach, namespace="/other")
        done = goals("1 2", code=0)
        assert "has no robot in the namespace /other (robots: /dd100_0000)" in done.err
        assert cells(done.lines[1])[5] == "-"


def test_a_reset_ends_the_goal_and_the_next_goal_begins_with_a_new_initial_pose(
    goals: Graphrun, nav2: Nav2, peer: DdsTransport, domain_id: int
) -> None:
    localization = Localization(peer, NAMESPACE)
    with running(domain_id), Client(find(""), PATIENCE) as control:
        assert eventually(lambda: float(control.ask("state")["time"]) > 2.0)

        def reset(server: Nav2Peer, goal: bytes) -> None:
            nav2_peer.dawdle(server, goal)
            control.ask("reset")
            if server.wait(lambda: goal in server.cancelled):
                server.answer_cancel()
                server.answer_result(5)

        nav2(reset, nav2_peer.reach)
        done = goals("1 2", "0.3 0.4", code=1)
    first, second = (cells(line) for line in done.lines[1:3])
    assert first == ["1 2 0", "reset", "-", "-", "-", "-", "-", "-", "the run was reset"]
    assert second[:2] == ["0.3 0.4 0", "reached"]
    assert done.err.count(f"publishing the true pose on {NAMESPACE}/initialpose") == 2
    assert len(localization.taken) >= 2


def test_objects_within_reach_of_the_footprint_at_a_goal_are_reported(
    goals: Graphrun, nav2: Nav2, domain_id: int
) -> None:
    with running(domain_id), Client(find(""), PATIENCE) as control:
        late = {"use": "robots/dd100.yaml", "position": [2.0, 0.0, 0.03], "namespace": "late"}
        control.ask("spawn", {"name": "late", "use": late})
        nav2(nav2_peer.reach)
        done = goals("1.6 0", "0 1.5", code=0)
    (told,) = [line for line in done.err.splitlines() if "late" in line]
    assert told == "goal 1/2 (1.6 0 0): late stands where the robot turns"
