"""`graphrun view`: show a recorded run on a web page, where it can be played and searched."""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.quantities import seconds
from graphengine.format import interrupts

if TYPE_CHECKING:
    from graphengine.api.recording_page import ReplayLog
    from graphengine.cli.recorded_run import RecordedRun
    from graphengine.recording.player import RecordingPlayer


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun view` to its parser."""
    from graphengine.cli.common import add_access_arguments, add_page_arguments

    parser.add_argument("recording", metavar="FILE", type=Path, help="recording made by `graphrun run --record FILE`")
    parser.add_argument(
        "--html", metavar="FILE", type=Path, help="write the recording as one HTML file instead of serving a page"
    )
    at = "simulation time from the start of the recording, s, that the page shows first"
    parser.add_argument("--at", metavar="SECONDS", type=seconds, default=0.0, help=at)
    add_page_arguments(parser)
    add_access_arguments(parser)
    parser.set_defaults(against=None, set=[], seed=None, rays=None)  # a recording is shown with its own options
    parser.epilog = (
        "In the background, the run is replayed from its recorded inputs, and its output is compared with the recorded"
        " output."
    )


def execute(arguments: argparse.Namespace) -> int:
    """Serve the web page until Ctrl-C, or write the HTML file; return 0, or 1 if the recorded scene has errors.

    Raises:
        UsageError: the file cannot be replayed, or the name of the file to write has the wrong suffix.
    """
    from graphengine.api.recording_page import ReplayLog
    from graphengine.api.viewing import check_packages
    from graphengine.cli.common import check_suffix
    from graphengine.cli.recorded_run import start_recorded_run

    log = ReplayLog()
    if arguments.html is None:
        check_packages()
    else:
        check_suffix(arguments.html, ".html", ".htm")
    with interrupts.by_sigterm():  # so that the extracted files are removed
        show = _view if arguments.html is None else _write_html
        return start_recorded_run(arguments, lambda run: show(arguments, run, log), log.log)


def _write_html(arguments: argparse.Namespace, run: RecordedRun, log: ReplayLog) -> int:
    from graphengine.api.recording_page import write_recording
    from graphengine.cli.common import clean
    from graphengine.cli.progress import progress
    from graphengine.format.files import near
    from graphengine.recording.player import RecordingPlayer

    session, network = run.runner.session, run.runner.network
    with contextlib.closing(RecordingPlayer(session, network, run.recording, log.marks, run.warn)) as player:
        with progress("replaying", lambda: run.recording.share_read, 1.0):
            write_recording(player, log, arguments.html)
        print(run.plain(_summary(player)), file=sys.stderr)
    print(clean(f"{near(str(arguments.html))}: {arguments.html.stat().st_size / 1e6:.1f} MB"))
    return 0


def _view(arguments: argparse.Namespace, run: RecordedRun, log: ReplayLog) -> int:
    from graphengine.api.recording_view import Playback, open_recording_page, turn
    from graphengine.recording.player import RecordingPlayer

    def tell(text: str) -> None:
        print(run.plain(text), file=sys.stderr, flush=True)

    runner, told = run.runner, False
    with contextlib.closing(
        RecordingPlayer(runner.session, runner.network, run.recording, log.marks, run.warn)
    ) as player:
        playback = Playback(player)
        playback.seek(round(arguments.at / runner.session.clock.delta))
        with contextlib.closing(open_recording_page(playback, arguments.view_host, arguments.view_port)) as feed:
            tell(f"see it: {feed.wait()}")
            with contextlib.suppress(KeyboardInterrupt):
                while True:
                    turn(playback, feed)
                    if player.complete and not told:
                        told = True
                        tell(_summary(player))
    return 0


def _summary(player: RecordingPlayer) -> str:
    """Return a text for the user: the result of comparing replay and recording, and the error that ended the run, if any."""
    from graphengine.cli.replay import verdict

    found = player.difference
    lines = [verdict(None, player.replay)] if found is None else ["\n  ".join([str(found), *found.lines])]
    if player.failure:
        lines.append(f"ends with: {player.failure}")
    elif player.recording.cut_off:
        lines.append(
            f"the run was cut off: the recording ends at t = {player.recording.times.seconds(player.built):.3f} s"
        )
    return "\n".join(lines)
