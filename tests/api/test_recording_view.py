"""The clock of a recording that is looked at: it plays at a speed, waits for the session, and stops at the end."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import pytest

from graphengine.api.recording_view import SPEEDS, Playback
from graphengine.format.errors import UsageError
from graphengine.recording.player import RecordingPlayer
from tests.recording.harness import DRIVE, playing, record, rewritten

TICKS = 120


class Clock:
    """A wall clock that the test moves."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("playback") / "out.mcap"
    record(made, TICKS, "dd100_flat", commands=DRIVE)
    return made


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture(scope="module")
def player(path: Path) -> Iterator[RecordingPlayer]:
    with playing(path) as made:
        made.build()
        yield made


@pytest.fixture
def playback(player: RecordingPlayer, clock: Clock) -> Playback:
    """A recording that was replayed, paused at its start."""
    player.show(0)
    return Playback(player, clock)


def after(playback: Playback, clock: Clock, seconds: float) -> int:
    """The tick that is shown when some time has passed, frame by frame."""
    ends = clock.now + seconds
    while clock.now < ends - 1e-9:
        clock.now += 0.05
        playback.show()
    return playback.player.position


@pytest.mark.parametrize("speed", SPEEDS)
def test_a_recording_plays_at_each_speed(playback: Playback, clock: Clock, speed: float) -> None:
    playback.obey({"do": "speed", "factor": speed})
    playback.obey({"do": "play"})
    assert after(playback, clock, 0.2) == pytest.approx(0.2 * 60 * speed, abs=1)
    playback.obey({"do": "pause"})
    held = playback.player.position
    assert after(playback, clock, 0.2) == held


def test_at_the_end_it_stops_and_plays_again_from_the_start(playback: Playback, clock: Clock) -> None:
    playback.obey({"do": "seek", "tick": TICKS - 3})
    playback.obey({"do": "play"})
    assert after(playback, clock, 0.2) == TICKS
    assert (playback.playing, playback.idle) == (False, True)
    playback.obey({"do": "play"})
    assert 3 <= after(playback, clock, 0.2) <= 12


def test_steps_hold_the_time(playback: Playback, clock: Clock) -> None:
    playback.obey({"do": "seek", "tick": 50})
    playback.obey({"do": "play"})
    after(playback, clock, 0.1)
    begun = playback.player.position
    for ticks in (1, -1, -1, 60):
        playback.obey({"do": "step", "ticks": ticks})
        begun += ticks
        assert after(playback, clock, 0.1) == begun
    assert playback.playing is False
    playback.obey({"do": "step", "ticks": -1000})
    assert after(playback, clock, 0.1) == 0


def test_a_tick_that_is_not_replayed_yet_is_shown_when_it_is(path: Path, clock: Clock) -> None:
    with playing(path) as player:
        playback = Playback(player, clock)
        playback.obey({"do": "seek", "tick": 100})
        assert after(playback, clock, 0.05) == 0
        while not player.complete:
            player.build(0.0)
            assert after(playback, clock, 0.05) == min(player.built, 100)
            assert playback.facts()["recording"]["built"] == player.built
        assert playback.verdict() == "identical"


def test_time_waits_for_a_replay_that_is_slower(path: Path, clock: Clock) -> None:
    with playing(path) as player:
        playback = Playback(player, clock)
        playback.obey({"do": "speed", "factor": 8.0})
        playback.obey({"do": "play"})
        for built in range(1, 20):
            player.build(0.0)
            after(playback, clock, 0.1)
            assert player.position <= built
        assert playback.verdict() == "identical up to 0.3 s"
        player.build()
        after(playback, clock, 0.05)
        assert player.position < 100


def test_a_replay_with_a_long_way_back_goes_on_only_in_pauses_and_until_somebody_asks(path: Path) -> None:
    ticking = itertools.count(step=0.2)  # each look at the clock finds that a fifth of a second has passed
    with playing(path) as player:
        playback = Playback(player, lambda: next(ticking))
        playback.build(lambda: True)
        playback.show()
        assert (player.built, player.position) == (1, 0)
        playback.obey({"do": "play"})
        playback.build(lambda: True)
        assert player.built == 1
        playback.obey({"do": "pause"})
        playback.build(lambda: True)
        assert player.built == 2


def test_the_verdict_tells_the_first_difference(path: Path) -> None:
    other = rewritten(path, manifest={"overrides": '{"PublishClock.topicName": "time"}'})
    with playing(other) as player:
        player.build()
        said = Playback(player).verdict()
    assert said == "different in tick 1, t = 0.016667 s: /time; from this tick on, the page shows the replay instead"


@pytest.mark.parametrize(
    ("asked", "advice"),
    [
        ({"do": "reset"}, "legal: play, pause, seek, step, speed"),
        ({"do": ["seek"]}, "legal: play, pause, seek, step, speed"),
        ({}, "legal: play, pause, seek, step, speed"),
        ({"do": "speed", "factor": 3}, "legal: 0.25, 0.5, 1, 2, 4, 8"),
        ({"do": "speed", "factor": [1]}, "legal: 0.25, 0.5, 1, 2, 4, 8"),
        ({"do": "seek", "tick": 1.5}, "expected a whole number"),
        ({"do": "seek", "tick": True}, "expected a whole number"),
        ({"do": "seek"}, "expected a whole number"),
        ({"do": "step", "ticks": 10**400}, "expected a whole number"),
    ],
)
def test_what_viewers_cannot_mean_is_refused(playback: Playback, asked: dict[str, object], advice: str) -> None:
    with pytest.raises(UsageError, match=advice):
        playback.obey(asked)
