"""Writes a recording as one HTML file: replays it, samples the session, and collects the messages of nodes."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from graphengine.recording.marks import LONGEST, Marks
from graphengine.recording.player import RecordingPlayer
from graphengine.view.html.html_file import LogEntry, robot_plots, write_html
from graphengine.view.html.trace import SceneTrace

MAX_ENTRIES = 1000
"""Maximum number of messages of nodes in the log."""


def log_entry(tick: int, severity: str, node: str, text: str) -> LogEntry:
    """Return the entry of the log for a message of a node: its first line, with the node's prim path if it has one."""
    return LogEntry(tick, severity, (f"{node}: {text}" if node else text).partition("\n")[0][:LONGEST])


class ReplayLog:
    """Collects the messages that nodes log in a replay: errors as marks, other messages as entries of the log.

    Attributes:
        marks: marks of the replay.
        entries: the messages that are not errors.
    """

    def __init__(self) -> None:
        self.marks = Marks()
        self.entries: list[LogEntry] = []

    def log(self, severity: str, node: str, text: str) -> None:
        """Add a message. A session can use this method as its `log` function."""
        self.marks.log(severity, node, text)
        if severity != "error" and self.marks.tick and len(self.entries) < MAX_ENTRIES:
            self.entries.append(log_entry(self.marks.tick, severity, node, text))


def sample_replay(player: RecordingPlayer) -> SceneTrace:
    """Replay a recording to its end and return its samples."""
    trace = SceneTrace(player.session)
    trace.sample(0)
    while not player.complete:
        before = player.built
        player.build(0.0)
        if player.built > before:
            trace.sample(player.built, last=player.complete or player.built == player.length)
    return trace


def write_recording(player: RecordingPlayer, log: ReplayLog, path: Path) -> None:
    """Replay a recording to its end and write it as one HTML file.

    Args:
        player: player of the recording; it uses the marks of `log`.
        log: the log of the replayed session.
        path: file to write; an older file is replaced when the new one is complete.

    Raises:
        OSError: the file cannot be written.
    """
    trace, title = sample_replay(player), player.recording.path.name
    marks = [LogEntry(**asdict(mark)) for mark in log.marks.all]
    write_html(trace, path, title=title, plots=robot_plots(trace), marks=marks, log=log.entries)
