"""`graphrun replay`: replay a recorded run and compare the output byte by byte."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.options import add_repeatable, add_value
from graphengine.cli.quantities import whole

if TYPE_CHECKING:
    from graphengine.cli.recorded_run import RecordedRun
    from graphengine.recording.replay import Difference, Replay
    from graphengine.runtime.session_core import SessionCore

LONGEST = 80
"""Maximum number of characters of a port value to print."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun replay` to its parser."""
    from graphengine.cli.common import add_access_arguments

    add_value(parser, "recording", "FILE", "recording made by `graphrun run --record FILE`", type=Path)
    against = "replay the recorded inputs to this scene or graph instead of the recorded one"
    add_value(parser, "--against", "SCENE|GRAPH", against)
    add_repeatable(parser, "--ignore", "TOPIC", "topic to leave out of the comparison; globs allowed")
    values = "value for an input, [ROBOT/][GRAPH/]NODE.PORT=VALUE, globs allowed, in addition to the values of the recorded run"
    add_repeatable(parser, "--set", "NODE.PORT=VALUE", values)
    parser.add_argument("--seed", type=whole, help="seed of all random generators (default: that of the recorded run)")
    rays = "ray casting of lidars (default: as in the recorded run)"
    parser.add_argument("--rays", choices=("auto", "mujoco", "fast"), help=rays)
    add_access_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Replay the recording and compare the output; return 0 if all bytes are equal, else 1.

    Raises:
        UsageError: the file cannot be replayed.
    """
    from graphengine.cli.recorded_run import start_recorded_run

    return start_recorded_run(arguments, lambda run: _replay(arguments, run))


def _replay(arguments: argparse.Namespace, run: RecordedRun) -> int:
    from graphengine.cli.progress import progress
    from graphengine.format.errors import RecordingError
    from graphengine.recording.replay import Replay

    recording = run.recording
    replay = Replay(run.runner.session, run.runner.network, recording, arguments.ignore, run.warn)
    try:
        with progress("replaying", lambda: recording.share_read, 1.0):
            found = replay.run()
    except RecordingError as error:
        raise RecordingError(f"{error}\n  before that, {_counted(replay)} are identical") from None
    for pattern in sorted(replay.idle_patterns) if found is None else ():
        run.warn(f"--ignore {pattern}: no message was sent on a matching topic")
    if found is None and not replay.messages:
        run.warn("no message was compared, as the run publishes nothing; values of ports are not compared")
    if found is None and recording.cut_off:
        run.warn(f"the run was cut off: the recording ends at t = {recording.times.seconds(replay.ticks):.3f} s")
    print(run.plain(verdict(found, replay)))
    return 1 if found else 0


def verdict(found: Difference | None, run: Replay) -> str:
    """Return the result of the comparison as text: `identical` with counts, or the first difference and its source."""
    if found is None:
        return f"identical: {_counted(run)}, {run.recording.times.seconds(run.ticks):.3f} s"
    lines = [line for text in found.lines for line in text.split("\n")]
    before = f"before that, {_counted(run)} are identical"
    return "\n  ".join([str(found), *_published_by(found.node, run.session), *lines, before])


def _counted(run: Replay) -> str:
    from graphengine.cli.common import counted

    return f"{counted(run.messages, 'message')} in {counted(run.ticks, 'tick')}"


def _published_by(node: str, session: SessionCore) -> list[str]:
    """Return lines about the node that published a message: its type, file and line, and the values of its wired inputs.

    Args:
        node: prim path of the node; if empty, no lines are returned.
        session: the session of the replay, from which the values are read.
    """
    for run in session.graphs:
        graph, nodes = run.executor.graph, run.executor.nodes
        for instance in graph.instances:
            if f"{graph.prim_path}/{instance.id}" == node:
                wires = [wire for wire in graph.data_wires if wire.target == instance.index]
                read = [f"{wire} = {_short(getattr(nodes[wire.target], wire.target_field))}" for wire in wires]
                return [f"published by {node} ({instance.cls.type_name}, {instance.span})", *read]
    return [f"published by {node}"] if node else []


def _short(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"
