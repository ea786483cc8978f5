"""`graphrun run`: a scene or graph, live on the network."""

from __future__ import annotations

import argparse
import math
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from graphengine.cli.console import Console
from graphengine.cli.quantities import duration, rate

if TYPE_CHECKING:
    from graphengine.runtime.command_queue import Desk
    from graphengine.runtime.session_core import SessionCore


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    from graphengine.cli.common import add_file_arguments, add_transport_argument

    add_file_arguments(parser)
    simulated = "simulation time to run: 10, 10s, 500ms, 2min"
    parser.add_argument("--for", metavar="TIME", dest="duration", type=duration, help=simulated)
    pace = "realtime, max, or a factor of real time (default realtime; max for --transport memory)"
    parser.add_argument("--rate", type=rate, help=pace)
    parser.add_argument("--paused", action="store_true", help="begin with a pause, which `graphrun ctl play` ends")
    parser.add_argument("--no-control", action="store_true", help="let `graphrun ctl` not reach the run")
    interfaces = (
        "let everybody on the network stop, step, reset, spawn and move, by ROS 2's simulation_interfaces, in a namespace"
        " such as /one where several runs are in one domain (default /)"
    )
    parser.add_argument(
        "--simulation-interfaces", metavar="NAMESPACE", nargs="?", type=_namespace, const="/", help=interfaces
    )
    add_transport_argument(parser, reaching_others=False)
    parser.add_argument("--keep-going", action="store_true", help="a node that raises ends its branch, not the run")
    bad = "a value from a wire that a node cannot use is dropped and counted, or ends the run (default drop)"
    parser.add_argument("--bad-values", choices=("drop", "stop"), default="drop", help=bad)
    record = "MCAP file of all that is read, heard and said, for replay, ros2 bag and Foxglove; pictures are waited for"
    parser.add_argument("--record", metavar="FILE", type=Path, help=record)
    profile = "print at the end how often each node ran and fired and what time it took, measured in one tick of ten"
    parser.add_argument("--profile", action="store_true", help=profile)
    parser.add_argument("--force", action="store_true", help="let --record write over a file that is there")


def _namespace(text: str) -> str:
    """A namespace of ROS 2, absolute as they are; what names a file to run is none."""
    from graphengine.format.errors import TopicError
    from graphengine.messages.names import check_namespace

    try:
        check_namespace(text)
    except TopicError as error:
        advice = "write a namespace as in --simulation-interfaces /one, and what to run before it"
        raise argparse.ArgumentTypeError(f"{error.message}\n  {advice}") from None
    return text


def execute(arguments: argparse.Namespace) -> int:
    """0 when it ran to its end or was stopped, 1 with errors."""
    from graphengine.api.runner import RunOptions, check_recording
    from graphengine.api.scene import start_runner
    from graphengine.cli.common import clean, counted, open_scene
    from graphengine.format.errors import UsageError

    if arguments.record is not None:
        try:
            check_recording(arguments.record, force=arguments.force)
        except UsageError as error:
            raise UsageError(f"--record {error}") from None
    scene = open_scene(arguments)
    if scene is None:
        return 1
    console = Console()
    options = RunOptions(
        transport=arguments.transport,
        keep_going=arguments.keep_going,
        bad_values=arguments.bad_values,
        record=arguments.record,
        force=arguments.force,
        simulation_interfaces=arguments.simulation_interfaces,
        log=console.say,
        fault=console.fault,
        patient=arguments.rate is not None and math.isinf(arguments.rate),
    )
    runner = start_runner(scene, options)
    session, loaded = runner.session, runner.scene
    console.network = runner.network
    with (
        _Signals(session),
        _channel(arguments, runner.desk, console),
        runner,
        _keys(session, console) as on_tick,
        _profiled(arguments, session, on_tick, console) as on_tick,
    ):
        graphs = counted(len(loaded.planned), "graph")
        what = f"{loaded.path}: {graphs}, {1.0 / session.clock.delta:g} Hz; {runner.network.description}"
        rays = session.services.world.rays_in_use
        what += (f"; rays {rays}" if rays else "") + (f"; recorded to {arguments.record}" if arguments.record else "")
        console.tell(clean(what))
        console.begin()
        try:
            runner.run(arguments.duration, arguments.rate, on_tick, paused=arguments.paused)
            session.end()
        finally:
            console.summarize(session)
    return 0


def _channel(arguments: argparse.Namespace, desk: Desk, console: Console) -> AbstractContextManager[object]:
    """Where `graphrun ctl` finds the run; the run goes on without, if that cannot be."""
    from graphengine.control.channel import Channel
    from graphengine.format.errors import ControlError

    if arguments.no_control:
        return nullcontext()
    try:
        return Channel(desk, Path(arguments.file).stem, os.environ)
    except ControlError as error:
        console.say("warning", "", f"graphrun ctl cannot reach this run: {error}")
        return nullcontext()


@contextmanager
def _keys(session: SessionCore, console: Console) -> Iterator[Callable[[SessionCore], bool]]:
    """What is to be called after each tick: it reads the terminal's keys, where a graph asked for them."""
    terminal = sys.stdin is not None and sys.stdin.isatty()
    if not session.services.keys.asked or not terminal:
        if session.services.keys.asked:
            advice = "the standard input, where a graph's keys come from, is no terminal\n  use `graphrun ctl press W`"
            console.say("warning", "", advice)
        yield console.on_tick
        return
    from graphengine.cli.held_keys import HeldTerminalKeys

    with HeldTerminalKeys() as keys:

        def on_tick(session: SessionCore) -> bool:
            keys.on_tick(session)
            return console.on_tick(session)

        yield on_tick


@contextmanager
def _profiled(
    arguments: argparse.Namespace, session: SessionCore, on_tick: Callable[[SessionCore], bool], console: Console
) -> Iterator[Callable[[SessionCore], bool]]:
    """What is to be called after each tick; with `--profile`, nodes are measured, and what came of it is printed at the end."""
    if not arguments.profile:
        yield on_tick
        return
    from graphengine.cli.common import clean, counted, table
    from graphengine.runtime.profile import Profile

    profile = Profile()

    def measured(session: SessionCore) -> bool:
        profile.begin_tick(session.ticks, session.graphs)
        return on_tick(session)

    profile.begin_tick(session.ticks, session.graphs)
    try:
        yield measured
    finally:
        nodes = profile.nodes()
        total = sum(node.seconds for node in nodes) or 1.0
        rows = [("node", "type", "runs", "fired", "us a run", "share")]
        for node in nodes:
            mean, share = f"{1e6 * node.seconds / node.runs:.1f}", f"{100 * node.seconds / total:.1f} %"
            rows.append((node.path, node.type, str(node.runs), str(node.fired), mean, share))
        console.tell(clean(f"{table(rows)}\nin {counted(profile.sampled, 'tick')} of {session.ticks}"))


class _Signals:
    """Ctrl-C, SIGTERM and a terminal that is closed end the run after the tick, or at once while it waits.

    A second one ends the process. What a run under `nohup` is to outlive it goes on outliving.
    """

    def __init__(self, session: SessionCore) -> None:
        self.session = session
        self.before: dict[int, Any] = {}

    def __enter__(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
                self.before[number] = signal.signal(number, self._stop)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_DFL)
        self.session.interrupt()

    def __exit__(self, *_: object) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)
