"""`graphrun view`: show a recorded run on a web page, where it can be played and searched."""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.options import add_value
from graphengine.cli.quantities import seconds
from graphengine.format import interrupts

if TYPE_CHECKING:
    from graphengine.api.recording_page import ReplayLog
    from graphengine.cli.recorded_run import RecordedRun
    from graphengine.recording.player import RecordingPlayer


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun view` to its parser."""
    from graphengine.cli.common import add_access_arguments, add_page_arguments

    add_value(parser, "recording", "FILE", "recording made by `graphrun run --record FILE`", type=Path)
    add_value(parser, "--html", "FILE", "write the recording as one HTML file instead of serving a page", type=Path)
    at = "simulation time from the start of the recording, s, that the page shows first"
    add_value(parser, "--at", "SECONDS", at, type=seconds, default=0.0)
    add_page_arguments(parser)
    add_access_arguments(parser)
    parser.set_defaults(against=None, set=[], seed=None, rays=None)  # a recording is shown with its own options
    parser.epilog = "In the background, graphrun replays the run and compares its output with the recorded output."


def execute(arguments: argparse.Namespace) -> int:
    """Serve the web page until Ctrl-C, or write the HTML file; return 0, or 1 if the recorded scene has errors.

    Raises:
        UsageError: the file cannot be replayed, or the name of the file to write has the wrong suffix.
    """
    from graphengine.api.recording_page import ReplayLog
    from graphengine.api.viewing import check_packages
    from graphengine.cli.common import check_suffix
    from graphengine.cli.recorded_run import start_recorded_run
    from graphengine.recording.player import RecordingPlayer

    log = ReplayLog()
    if arguments.html is None:
        check_packages()
    else:
        check_suffix(arguments.html, ".html", ".htm")

    def play(run: RecordedRun) -> int:
        session, network = run.runner.session, run.runner.network
        with contextlib.closing(RecordingPlayer(session, network, run.recording, log.marks, run.warn)) as player:
            if arguments.html is None:
                _view(arguments, run, player)
            else:
                _write_html(arguments.html, run, player, log)
        return 0

    with interrupts.by_sigterm():  # so that the extracted files are removed
        return start_recorded_run(arguments, play, log.log)


def _write_html(path: Path, run: RecordedRun, player: RecordingPlayer, log: ReplayLog) -> None:
    from graphengine.api.recording_page import write_recording
    from graphengine.cli.common import clean
    from graphengine.cli.progress import progress
    from graphengine.format.files import near

    with progress("replaying", lambda: run.recording.share_read, 1.0):
        write_recording(player, log, path)
    print(run.plain(_summary(player)), file=sys.stderr)
    print(clean(f"{near(str(path))}: {path.stat().st_size / 1e6:.1f} MB"))


def _view(arguments: argparse.Namespace, run: RecordedRun, player: RecordingPlayer) -> None:
    from graphengine.api.recording_view import Playback, open_recording_page, turn

    def tell(text: str) -> None:
        print(run.plain(text), file=sys.stderr, flush=True)

    playback, told = Playback(player), False
    playback.seek(round(arguments.at / run.runner.session.clock.delta))
    with contextlib.closing(open_recording_page(playback, arguments.view_host, arguments.view_port)) as feed:
        tell(f"see it: {feed.wait()}")
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                turn(playback, feed)
                if player.complete and not told:
                    told = True
                    tell(_summary(player))


def _summary(player: RecordingPlayer) -> str:
    """Return a text for the user with the result of the comparison, and the error, if any, that ended the recorded run."""
    from graphengine.cli.replay import verdict

    found = player.difference
    lines = [verdict(None, player.replay)] if found is None else ["\n  ".join([str(found), *found.lines])]
    if player.failure:
        lines.append(f"ends with: {player.failure}")
    elif player.recording.cut_off:
        end = player.recording.times.seconds(player.built)
        lines.append(f"the run was cut off: the recording ends at t = {end:.3f} s")
    return "\n".join(lines)
