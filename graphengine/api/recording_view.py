"""Shows a recording on a web page: viewers control a playback clock, and a replayed session follows the clock."""

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
from graphengine.messages.definitions import DEFINITIONS
from graphengine.recording.player import RecordingPlayer
from graphengine.runtime.command_queue import CommandQueue

if TYPE_CHECKING:
    from graphengine.view.feed import Feed, Plots

SPEEDS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
SLICE = 0.04
"""Wall time for which recorded ticks are replayed in the background between two updates of the page, s."""
WORTH = 4
"""Minimum duration of a background replay, as a multiple of the time that the session needs to return to the shown tick."""
LONGEST_SEEK = 0.3
"""If a seek takes longer than this wall time, s, the page shows the tick that the replay has reached so far."""
MOST_POINTS = 20_000
"""Maximum number of samples of a plotted value over a recording."""
IDLE = 0.02
"""Wall time between two polls for requests of viewers while the page is idle, s."""


class Playback:
    """Playback of a recording at a speed that viewers set; ticks are replayed in the background.

    Args:
        player: player of the recording.
        clock: function that returns wall time, s.
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
        """Number of the tick to show; the fraction is the elapsed share of the time until the next tick."""
        self._away = False
        """Whether the session is at the last replayed tick, because of the background replay, and not at the shown tick."""
        self._return = 0.0
        """Duration, in wall time, of the session's latest return from the last replayed tick to the shown tick, s."""
        self._plotted = 0
        """Number of ticks of which the plotted values were sampled since `_restarts`, the last change of the expressions."""
        self._restarts = 0

    def obey(self, asked: Mapping[str, Any]) -> None:
        """Execute a request of a viewer.

        Args:
            asked: request as a mapping. The key `do` is `play`, `pause`, `seek` (with a tick number in the key `tick`), `step`
                (with a number of ticks in the key `ticks`) or `speed` (with one of `SPEEDS` in the key `factor`).

        Raises:
            UsageError: the request is invalid.
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
            raise UsageError(f"factor: unknown playback speed; {listing([f'{speed:g}' for speed in SPEEDS])}")
        else:
            raise UsageError(f"unknown playback command; {listing(['play', 'pause', 'seek', 'step', 'speed'])}")

    def seek(self, tick: int) -> None:
        """Set the tick to show; if the tick is not replayed yet, it is shown when the replay reaches it."""
        self._goal = float(min(max(tick, 0), self.player.length))

    def show(self) -> None:
        """Advance playback to the current wall time, and bring the session to the tick to show."""
        player, now = self.player, self._clock()
        elapsed, self._seen = min(now - self._seen, 0.1), now
        if self.playing and player.position == int(self._goal):  # otherwise the clock waits for the session
            self._goal += elapsed * self.speed / self._delta
        if self._goal >= player.length and player.complete:
            self._goal, self.playing = float(player.length), False
        player.show(int(self._goal), LONGEST_SEEK)
        if self._away:
            self._away, self._return = False, self._clock() - now

    def build(self, interrupted: Callable[[], bool] = lambda: False) -> None:
        """Replay further ticks in the background, unless playback would stutter.

        The same session replays ahead and shows ticks, so it must return to the shown tick after each call. The longer a return
        takes, the longer each call replays, so that the session returns less often.

        Args:
            interrupted: function called after each tick; the call ends when it returns True.
        """
        if seconds := self._slice():
            self.player.build(seconds, interrupted)

    def plot(self, plots: Plots, interrupted: Callable[[], bool] = lambda: False) -> None:
        """Sample plotted values of further ticks in the background, as `build` replays them."""
        if seconds := self._slice():
            every = -(-self.player.length // MOST_POINTS)

            def seen(tick: int) -> None:
                if tick % every == 0:
                    plots.sample(tick * self._delta)

            with plots.sampling():
                self._plotted = self.player.visit(self._plotted + 1, seconds, seen, interrupted) - 1

    def _slice(self) -> float:
        """Return the wall time for which the session may leave the shown tick, s; 0 if playback would stutter."""
        if self.playing and self._return > SLICE and self.player.position < self.player.built:
            return 0.0
        self._away = True
        return max(SLICE, WORTH * self._return)

    def behind(self, plots: Plots) -> bool:
        """Return whether replayed ticks remain of which plotted values are not sampled yet."""
        if plots.restarts != self._restarts:
            self._restarts, self._plotted = plots.restarts, 0
        return plots.wanted and self._plotted < self.player.built

    @property
    def idle(self) -> bool:
        """Whether the recording is fully replayed and playback is paused."""
        return self.player.complete and not self.playing and self.player.position == int(self._goal)

    def facts(self) -> Mapping[str, Any]:
        """Return the state of the playback for the page, as JSON values."""
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
        """Return the result of comparing the replay with the recording, in one line."""
        player = self.player
        if player.difference is not None:
            text = f"{player.difference}; from this tick on, the page shows the replay instead"
        else:
            text = "identical" if player.complete else f"identical up to {player.built * self._delta:.1f} s"
        if player.failure:
            return f"{text}; ends with: {player.failure.partition(chr(10))[0]}"
        cut_off = player.complete and player.recording.cut_off
        return f"{text}; the run was cut off, and the recording ends here" if cut_off else text

    def marks(self) -> Sequence[Mapping[str, Any]]:
        """Return the events that the replay has found so far, as JSON values."""
        return [asdict(mark) for mark in self.player.marks.all]


def open_recording_page(playback: Playback, host: str, port: int) -> Feed:
    """Start the web page of a recording and return its feed; `wait` of the feed returns its URL. The caller closes the feed.

    Args:
        playback: playback of the recording to show.
        host: network address to listen on.
        port: TCP port; 0 chooses a free port.

    Raises:
        UsageError: the extra `view` is not installed.
    """
    check_packages()
    from graphengine.api.plot_values import PlotValues
    from graphengine.view.feed import Feed

    def lost(text: str) -> None:
        raise UsageError("the process that serves the page has ended")

    title, session = playback.player.recording.path.name, playback.player.session
    floor = functools.partial(make_floor, session)
    plots, queue = PlotValues(session, DEFINITIONS, None), CommandQueue()
    return Feed(session, queue, title, host, port, _NoDriver(), lost, make_floor=floor, plots=plots, playback=playback)


def turn(playback: Playback, feed: Feed) -> None:
    """Execute the requests of viewers, update the page, and continue the background replay for a short time.

    Raises:
        UsageError: the process that serves the page has ended.
    """
    playback.show()
    feed.after_tick()
    if playback.behind(feed.plots):
        playback.plot(feed.plots, lambda: feed.asked)
        feed.forget_costs()
    elif not playback.player.complete:
        playback.build(lambda: feed.asked)
        feed.forget_costs()
    elif playback.idle:
        time.sleep(IDLE)


class _NoDriver:
    """Ignores drive commands: a recording cannot be changed."""

    def topics(self) -> Mapping[str, str]:
        """Return an empty mapping, so that the page offers no robot to drive."""
        return {}

    def drive(self, topic: str, twist: tuple[float, float, float] | None) -> None:
        """Never called, as there are no topics."""


def _whole(number: Any, name: str) -> int:
    if type(number) is not int or abs(number) > 10**15:
        raise UsageError(f"{name}: expected a whole number")
    return number
