"""The web page on which a recording is looked at: a clock that viewers start, stop and set, and a session that follows it."""

from __future__ import annotations

import functools
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from graphengine.api.viewing import check_packages, make_floor
from graphengine.format.errors import UsageError
from graphengine.format.wording import listing
from graphengine.recording.player import RecordingPlayer
from graphengine.runtime.command_queue import Desk

if TYPE_CHECKING:
    from graphengine.view.feed import Feed

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
SLICE = 0.04
"""Seconds of wall time for which the replay goes on between two frames."""
WORTH = 4
"""How many times as long as the way back to the shown tick the replay goes on."""
LONGEST_SEEK = 0.3
"""Seconds of wall time after which a slow seek shows how far it is."""
IDLE = 0.02
"""Seconds of wall time between two looks at what viewers ask for, where nothing is to be done."""


class Playback:
    """Plays a recording at a speed, and replays it in the background.

    Args:
        player: player of the recording.
        clock: wall clock, s.
    """

    def __init__(self, player: RecordingPlayer, clock: Callable[[], float] = time.monotonic) -> None:
        self.player = player
        self.playing = False
        self.speed = 1.0
        self.folder = f"{player.recording.workspace.folder}{os.sep}"
        self._delta = player.session.clock.delta
        self._clock = clock
        self._seen = clock()
        self._goal = 0.0
        """The tick to show, with the part of the next one that has passed."""
        self._away = False
        """Whether the session is where the replay goes on, and not at the shown tick."""
        self._return = 0.0
        """Wall time that the last way back from there took, s; long where robots were spawned between."""

    def obey(self, asked: Mapping[str, Any]) -> None:
        """Do what a viewer asks for.

        Args:
            asked: `do` is `play`, `pause`, `seek` with a `tick`, `step` with a number of `ticks`, or `speed` with a `factor`.

        Raises:
            UsageError: it is none of these.
        """
        do = asked.get("do")
        if do == "play":
            self.playing = True
            if self._goal >= self.player.length:
                self._goal = 0.0
        elif do == "pause":
            self.playing = False
        elif do == "seek":
            self.seek(_whole(asked.get("tick"), "tick"))
        elif do == "step":
            self.playing = False
            self.seek(self.player.position + _whole(asked.get("ticks"), "ticks"))
        elif do == "speed" and asked.get("factor") in SPEEDS:
            self.speed = float(asked["factor"])
        elif do == "speed":
            raise UsageError(f"there is no such speed; {listing([f'{speed:g}' for speed in SPEEDS])}")
        else:
            raise UsageError(f"a recording knows no such thing; {listing(['play', 'pause', 'seek', 'step', 'speed'])}")

    def seek(self, tick: int) -> None:
        """Show a tick; one that is not replayed yet is shown as soon as it is."""
        self._goal = float(min(max(tick, 0), self.player.length))

    def show(self) -> None:
        """Bring the session to the tick that is to be shown now."""
        player, now = self.player, self._clock()
        elapsed, self._seen = min(now - self._seen, 0.1), now
        if self.playing and player.position == int(self._goal):  # else it waits for the session
            self._goal += elapsed * self.speed / self._delta
        if self._goal >= player.length and player.complete:
            self._goal, self.playing = float(player.length), False
        player.show(int(self._goal), LONGEST_SEEK)
        if self._away:
            self._away, self._return = False, self._clock() - now

    def build(self, interrupted: Callable[[], bool] = lambda: False) -> None:
        """Replay further for a slice of time, a long one if the way back is; not while that would make playing jerk.

        Args:
            interrupted: asked after each tick; True ends it.
        """
        if self.playing and self._return > SLICE and self.player.position < self.player.built:
            return
        self.player.build(max(SLICE, WORTH * self._return), interrupted)
        self._away = True

    @property
    def idle(self) -> bool:
        """Whether nothing is to be done until a viewer asks for something."""
        return self.player.complete and not self.playing and self.player.position == int(self._goal)

    def facts(self) -> Mapping[str, Any]:
        """What the page shows, as JSON has it."""
        player = self.player
        state = "playing" if self.playing else "paused"
        return {
            "state": "failed" if player.session.state == "failed" else state,
            "real_time_factor": self.speed if self.playing else 0.0,
            "recording": {
                "position": player.position,
                "built": player.built,
                "length": player.length,
                "complete": player.complete,
                "seconds": self._delta,
                "playing": self.playing,
                "speed": self.speed,
                "verdict": self.verdict(),
                "different": player.difference is not None,
            },
        }

    def verdict(self) -> str:
        """How the replay compares with the recording, in one line."""
        player = self.player
        if player.difference is not None:
            text = f"{player.difference}; from there on the replay is shown, not what was recorded"
        else:
            text = "identical" if player.complete else f"identical up to {player.built * self._delta:.1f} s"
        if player.failure:
            return f"{text}; ends with: {player.failure.partition(chr(10))[0]}"
        cut_off = player.complete and player.recording.cut_off
        return f"{text}; the run was cut off, and the recording ends here" if cut_off else text

    def marks(self) -> Sequence[Mapping[str, Any]]:
        """The events that were found so far."""
        return [asdict(mark) for mark in self.player.marks.all]


def open_recording_page(playback: Playback, host: str, port: int) -> Feed:
    """Start the page of a recording; the caller closes it.

    Args:
        playback: what is shown.
        host: address of the page.
        port: port of the page; 0 takes a free one.

    Raises:
        UsageError: the extra `view` is not installed, or the address cannot be used.
    """
    check_packages()
    from graphengine.view.feed import Feed

    def lost(text: str) -> None:
        raise UsageError("the process of the page has ended")

    title, session = playback.player.recording.path.name, playback.player.session
    floor = functools.partial(make_floor, session)
    return Feed(session, Desk(), title, host, port, _NoDriver(), lost, make_floor=floor, playback=playback)


def turn(playback: Playback, feed: Feed) -> None:
    """Do what viewers ask for, show them the recording as it is now, and replay further for a while.

    Raises:
        UsageError: the page's process has ended.
    """
    playback.show()
    feed.after_tick()
    if not playback.player.complete:
        playback.build(lambda: feed.asked)
        feed.forget_costs()
    elif playback.idle:
        time.sleep(IDLE)


class _NoDriver:
    """Drives nothing: what happened in a recording cannot be changed."""

    def topics(self) -> Mapping[str, str]:
        """No topics."""
        return {}

    def drive(self, topic: str, twist: tuple[float, float, float] | None) -> None:
        """Never called, as there are no topics."""


def _whole(number: Any, name: str) -> int:
    if type(number) is not int or abs(number) > 10**15:
        raise UsageError(f"{name}: write a whole number")
    return number
