"""What a session can be asked for, and what makes no sense."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from graphengine.format.errors import StateError, UsageError
from graphengine.format.spec import RobotUse
from graphengine.runtime.commands import COMMANDS, parse
from tests.control.conftest import MakeTicking

A, FORCE = {"entity": "a"}, [1.0, 0.0, 0.0]
MISSPELT = {"use": "r.yaml", "positon": [0, 0, 0]}
DEEP: list[Any] = [[]]
for _ in range(100):
    DEEP = [DEEP]


@pytest.mark.parametrize(
    ("name", "arguments", "words"),
    [
        ("paus", {}, "no command 'paus'\n  did you mean 'pause'?"),
        ("", {}, "no command ''"),
        ("x" * 1000, {}, "no command"),
        ("play", {"now": True}, "play: unknown key 'now'\n  keys: none"),
        ("step", {"ticks": 0}, "step: ticks: expected a "),
        ("step", {"ticks": 1.5}, "step: ticks: expected a "),
        ("step", {"ticks": 10**12}, "step: ticks: expected a "),
        ("reset", {"scope": "no"}, "reset: scope[0]: expected 'time', 'state', 'spawned' or 'all', got 'no'"),
        ("reset", {"scope": []}, "reset: scope: "),
        (
            "rate",
            {},
            "rate: missing key 'factor'\n  meaning: Real-time factor, or `realtime` (1), or `max` (as fast as possible).",
        ),
        ("rate", {"factor": 0.0}, "rate: factor: expected a value ≥ 0.01, got 0.0"),
        ("rate", {"factor": "fast"}, "rate: factor: expected a number, got 'fast'"),
        ("rate", {"factor": math.nan}, "rate: factor"),
        ("rate", {"factor": math.inf}, "rate: factor"),
        ("spawn", {"name": "a"}, "spawn: missing key 'use'"),
        ("spawn", {"name": "a", "use": MISSPELT}, "spawn: unknown key 'positon'\n  did you mean 'position'?"),
        ("move", {"entity": "a"}, "move: give a position, an orientation, or a velocity"),
        ("move", A | {"position": [0.0]}, "move: a position is [x, y] or [x, y, z], not 1 num"),
        ("move", {"entity": "", "position": [0.0, 0.0]}, "move: entity: expected text, got ''"),
        ("move", {"entity": "a", "position": [0.0, 0.0, math.nan]}, "move: position"),
        ("move", {"entity": "a", "orientation": {"quaternion_xyzw": [0.0, 0.0, 0.0, 2.0]}}, "must have length 1"),
        ("push", {"entity": "a", "duration": 1.0}, "push: give either a force (N) or an impulse (N s)"),
        ("push", {"entity": "a", "force": [1, 0, 0], "impulse": [1, 0, 0]}, "push: give either a force"),
        ("push", {"entity": "a", "force": [1.0, 0.0, 0.0]}, "push: a force needs a duration (s)"),
        ("push", A | {"force": FORCE, "duration": -1.0}, "push: duration: expected a value > 0, got -1.0"),
        ("command", {"robot": "a"}, "command: give positions, velocities or efforts"),
        ("command", {"robot": "a", "efforts": {"j": math.nan}}, "command: j: expected a finite number, got nan"),
        ("command", {"robot": "a", "velocities": [1.0]}, "command: velocities"),
        ("play", [], "play: the arguments must be a mapping, not a list"),
        ("push", {"at": DEEP}, "push: nested more than 64 levels deep"),
        ("push", {"entity": "", "force": [1.0, 0.0, 0.0], "duration": 1.0}, "push: entity"),
    ],
)
def test_invalid_arguments_are_refused(name: str, arguments: Any, words: str) -> None:
    with pytest.raises(UsageError) as caught:
        parse(name, arguments)
    assert words in str(caught.value)


def test_arguments_are_json_values() -> None:
    use = RobotUse(use="robots/dd100.yaml", position=(0.1, 0.2, 0.3))
    told = json.loads(json.dumps({"name": "late", "use": use.model_dump(mode="json")}))
    assert parse("spawn", told) == parse("spawn", {"name": "late", "use": use.model_dump()})


def test_recordings_contain_the_commands_that_change_the_simulation() -> None:
    recorded = {name for name, command in COMMANDS.items() if command.recorded}
    unrecorded = {"play", "pause", "step", "rate", "state", "clearance", "topics", "why", "view", "quit"}
    assert set(COMMANDS) - recorded == unrecorded | {"save", "place", "undo", "redo"}  # whose reload is recorded


def test_a_stopped_session_cannot_be_paused(ticking: MakeTicking) -> None:
    run = ticking()
    with pytest.raises(StateError, match="a stopped session cannot pause"):
        parse("pause").apply(run.session)
    assert run.session.state == "stopped"


@pytest.mark.parametrize(("factor", "pace"), [("realtime", 1.0), ("max", None), (0.5, 0.5), (3, 3.0)])
def test_a_rate_is_a_factor_of_real_time(ticking: MakeTicking, factor: Any, pace: float | None) -> None:
    run = ticking()
    parse("rate", {"factor": factor}).apply(run.session)
    assert run.session.pace == pace


@pytest.mark.parametrize(
    ("scope", "lines"),
    [
        ("time", ["zero commands", "reset time"]),
        ("state", ["reset state"]),
        ("spawned", []),
        (["state", "time"], ["zero commands", "reset state", "reset time"]),
        ("all", ["zero commands", "reset state", "reset time"]),
        (["spawned", "all"], ["zero commands", "reset state", "reset time"]),
    ],
)
def test_a_reset_affects_only_the_named_parts(ticking: MakeTicking, scope: Any, lines: list[str]) -> None:
    run = ticking()
    run.session.step(3)
    run.lines()
    parse("reset", {"scope": scope}).apply(run.session)
    assert run.lines() == lines
    assert run.session.time == (0.0 if "reset time" in lines else 0.75)
    assert run.node("Tick").number == (0.0 if "reset time" in lines else 3.0)
    assert run.session.state == "paused"
