"""True poses of a run: sampled over its control channel, and interpolated between the samples."""

from __future__ import annotations

import contextlib
import json
import math
import os
import socket
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.api.remote_robot import RemoteRobot
from graphengine.bringup.navigation.true_poses import PlanarPose, TruePoses
from graphengine.control import runs
from graphengine.devices.rotation import from_rpy, yaw_of
from graphengine.format import runtime_folder
from graphengine.format.errors import ControlError, UsageError
from tests.waiting import PATIENCE, eventually


class Samples(TruePoses):
    """Samples that a test gives, without a run."""

    def __init__(self, *states: dict[str, Any]) -> None:
        self.ended, self.paused = "", False
        self._times, self._poses, self._lock = [], [], threading.Lock()
        for state in states:
            self._robot = OneAnswer(state)
            self._sample()


class Answer:
    """A client of a run that gives one answer."""

    def __init__(self, state: dict[str, Any]) -> None:
        self.state = state

    def ask(self, command: str) -> dict[str, Any]:
        assert command == "state"
        return self.state


class OneAnswer(RemoteRobot):
    """A robot of a run that gives one answer."""

    def __init__(self, state: dict[str, Any]) -> None:
        self._client, self._namespace = Answer(state), "robot"  # type: ignore[assignment]


def state(time: float, x: float, y: float, yaw: float = 0.0) -> dict[str, Any]:
    robot = {"name": "robot", "namespace": "/robot", "position": (x, y, 0.1), "orientation": from_rpy(0.0, 0.0, yaw)}
    return {"state": "playing", "time": time, "robots": [robot]}


def test_a_pose_between_two_samples_is_interpolated() -> None:
    poses = Samples(state(1.0, 0.0, 0.0, 3.0), state(2.0, 1.0, -2.0, -3.0))
    middle = poses.at(1.5)
    assert middle is not None
    assert middle[:2] == pytest.approx((0.5, -1.0))
    assert abs(math.remainder(middle.yaw - math.pi, math.tau)) < 1e-12  # the short way round
    assert poses.at(1.0) == pytest.approx((0.0, 0.0, 3.0))
    assert (poses.at(0.9), poses.at(2.1)) == (None, None)


def test_the_way_counts_the_samples_between_two_times() -> None:
    poses = Samples(*(state(t, x, 0.0) for t, x in ((0.0, 0.0), (1.0, 1.0), (2.0, 3.0), (3.0, 2.0), (4.0, 9.0))))
    assert poses.way(1.0, 3.0) == 3.0
    assert poses.way(3.5, 3.6) == 0.0


def test_a_reset_discards_earlier_poses() -> None:
    poses = Samples(state(5.0, 1.0, 1.0), state(0.5, 0.0, 0.0))
    assert (poses.time, poses.newest[:2], poses.at(5.0)) == (0.5, (0.0, 0.0), None)


def test_the_newest_pose_of_a_robot_moved_in_a_pause_is_returned() -> None:
    assert Samples(state(1.0, 1.0, 1.0), state(1.0, 4.0, 1.0)).newest[:2] == (4.0, 1.0)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_a_yaw_is_measured_about_fixed_axes(roll: float, pitch: float, yaw: float) -> None:
    assert abs(math.remainder(yaw_of(from_rpy(roll, pitch, yaw)) - yaw, math.tau)) < 1e-6


def test_angles_differ_by_the_short_way_round() -> None:
    assert PlanarPose(0.0, 0.0, 3.1).turn(PlanarPose(0.0, 0.0, -3.1)) == pytest.approx(math.tau - 6.2)


# Runs


def test_without_a_run_the_error_says_how_to_start_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with pytest.raises(ControlError, match="no run to control"):
        TruePoses("", "/robot")


def test_the_run_is_chosen_by_the_namespace_of_the_robot(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    entries = [runs.Entry(name, number, tmp_path / name) for number, name in enumerate(("one", "two"))]
    namespaces = {"one": "/robot", "two": "/other"}

    class Client(Answer):
        def __init__(self, entry: runs.Entry, patience: float) -> None:
            told = state(1.0, 0.0, 0.0)
            told["robots"][0]["namespace"] = namespaces[entry.name]
            super().__init__(told)

        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None: ...

        def interrupt(self) -> None: ...

        def close(self) -> None: ...

    monkeypatch.setattr("graphengine.api.remote_robot.Client", Client)
    monkeypatch.setattr(runs, "running", lambda environment: entries)
    for namespace, name in (("/robot", "one"), ("other", "two")):
        poses = TruePoses("", namespace)
        assert poses.entry.name == name
        assert poses.time == 1.0
        poses.close()
    with pytest.raises(UsageError, match="there are 2 runs; choose one"):
        TruePoses("", "/third")
    namespaces["two"] = "/robot"
    with pytest.raises(UsageError, match="--run 1   two"):
        TruePoses("", "/robot")


@pytest.fixture
def mute_run(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    """A run that sends these answers, one for each request, and then no more, as after SIGSTOP."""
    answers: list[Any] = []
    with tempfile.TemporaryDirectory(prefix="graphrun-") as folder, contextlib.ExitStack() as stack:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        path = runtime_folder.folder(os.environ) / runs.entry_name("mute", 1)
        listener = stack.enter_context(socket.socket(socket.AF_UNIX))
        listener.bind(str(path))
        listener.listen()
        open_ends = []

        def serve() -> None:
            with contextlib.suppress(OSError):  # the test has ended
                while True:
                    connection, _ = listener.accept()
                    open_ends.append(connection)
                    while answers and connection.recv(65536):
                        connection.sendall(json.dumps({"result": answers.pop(0)}).encode() + b"\n")

        thread = threading.Thread(target=serve)
        thread.start()
        yield answers
        listener.shutdown(socket.SHUT_RDWR)
        for connection in open_ends:
            connection.close()
        thread.join(PATIENCE)


def test_a_run_that_never_answers_is_refused(mute_run: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.true_poses.PATIENCE", 0.1)
    with pytest.raises(ControlError, match=r"mute \(process 1\) did not answer within 0.1 s"):
        TruePoses("", "/robot")


def test_a_run_that_stops_answering_ends_the_samples(mute_run: list[Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graphengine.bringup.navigation.true_poses.PATIENCE", 0.1)
    mute_run.append(state(1.0, 0.0, 0.0))
    with contextlib.closing(TruePoses("", "/robot")) as poses:
        assert eventually(lambda: poses.ended)
        assert poses.ended == "mute (process 1) did not answer within 0.1 s"


def test_samples_are_closed_while_a_request_waits_for_its_answer(mute_run: list[Any]) -> None:
    mute_run.append(state(1.0, 0.0, 0.0))
    poses = TruePoses("", "/robot")
    closing = threading.Thread(target=poses.close, daemon=True)
    closing.start()
    closing.join(10.0)  # before the run's patience of 30 s
    assert not closing.is_alive()


def test_an_answer_that_cannot_be_used_ends_the_samples_with_the_reason(mute_run: list[Any]) -> None:
    mute_run += [state(1.0, 0.0, 0.0), {"time": 1.0}]
    with contextlib.closing(TruePoses("", "/robot")) as poses:
        assert eventually(lambda: poses.ended)
        assert "cannot be used (KeyError: 'robots')" in poses.ended
