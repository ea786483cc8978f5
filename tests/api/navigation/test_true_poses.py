"""True poses of a run: sampled over its control channel, and interpolated between the samples."""

from __future__ import annotations

import math
import threading
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.api.navigation.true_poses import PlanarPose, TruePoses, yaw_of
from graphengine.control import runs
from graphengine.devices.rotation import from_rpy
from graphengine.format.errors import ControlError, UsageError


class Samples(TruePoses):
    """Samples that a test gives, without a run."""

    def __init__(self, *states: dict[str, Any]) -> None:
        self.ended, self.paused, self._namespace = "", False, "robot"
        self._times, self._poses, self._lock = [], [], threading.Lock()
        for state in states:
            self._client = Answer(state)  # type: ignore[assignment]
            self._sample()


class Answer:
    """A client of a run that gives one answer."""

    def __init__(self, state: dict[str, Any]) -> None:
        self.state = state

    def ask(self, command: str) -> dict[str, Any]:
        assert command == "state"
        return self.state


def state(time: float, x: float, y: float, yaw: float = 0.0) -> dict[str, Any]:
    robot = {"namespace": "/robot", "position": (x, y, 0.1), "orientation": from_rpy(0.0, 0.0, yaw)}
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


def test_a_reset_discards_what_was_before() -> None:
    poses = Samples(state(5.0, 1.0, 1.0), state(0.5, 0.0, 0.0))
    assert (poses.time, poses.newest[:2], poses.at(5.0)) == (0.5, (0.0, 0.0), None)


def test_a_robot_that_was_moved_while_time_stands_is_where_it_was_put() -> None:
    assert Samples(state(1.0, 1.0, 1.0), state(1.0, 4.0, 1.0)).newest[:2] == (4.0, 1.0)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_a_yaw_is_that_of_the_rotation_about_fixed_axes(roll: float, pitch: float, yaw: float) -> None:
    assert abs(math.remainder(yaw_of(*from_rpy(roll, pitch, yaw)) - yaw, math.tau)) < 1e-6


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
        def __init__(self, entry: runs.Entry) -> None:
            told = state(1.0, 0.0, 0.0)
            told["robots"][0]["namespace"] = namespaces[entry.name]
            super().__init__(told)

        def __enter__(self) -> Client:
            return self

        def __exit__(self, *_: object) -> None: ...

        def close(self) -> None: ...

    monkeypatch.setattr("graphengine.api.navigation.true_poses.Client", Client)
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
