"""`graphrun run`: a scene or graph, live on the network."""

from __future__ import annotations

import argparse
import atexit
import gc
import math
import os
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from graphengine.cli.units import duration, rate

if TYPE_CHECKING:
    from graphengine.build import Assembly
    from graphengine.control.desk import CommandDesk
    from graphengine.diagnostics import NodeError
    from graphengine.ros.network import LiveNetwork
    from graphengine.session import Session


LATE_PICTURE = """a picture came too late and was dropped
  drawing does not keep up: make pictures smaller or fewer, or run slower, as with --rate 0.5"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Arguments of the verb."""
    from graphengine.cli.common import add_file_arguments

    add_file_arguments(parser)
    parser.add_argument(
        "--for", metavar="TIME", dest="duration", type=duration, help="simulation time to run: 10, 10s, 500ms, 2min"
    )
    parser.add_argument(
        "--rate",
        type=rate,
        default=None,
        help="realtime, max, or a factor of real time (default realtime; max for --transport memory)",
    )
    parser.add_argument("--paused", action="store_true", help="begin with a pause, which `graphrun ctl play` ends")
    parser.add_argument("--no-control", action="store_true", help="let `graphrun ctl` not reach the run")
    interfaces = "let everybody on the network stop, step, reset, spawn and move, by ROS 2's simulation_interfaces"
    parser.add_argument("--simulation-interfaces", action="store_true", help=interfaces)
    parser.add_argument("--transport", choices=("auto", "dds", "rclpy", "memory"), default="auto")
    parser.add_argument("--keep-going", action="store_true", help="a node that raises ends its branch, not the run")
    record = "MCAP file of all that is read, heard and said, for replay, ros2 bag and Foxglove; pictures are waited for"
    parser.add_argument("--record", metavar="FILE", type=Path, help=record)
    parser.add_argument("--force", action="store_true", help="let --record write over a file that is there")


def execute(arguments: argparse.Namespace) -> int:
    """0 when it ran to its end or was stopped, 1 with errors."""
    from graphengine import build
    from graphengine.cli.common import assemble_to_run, clean, counted
    from graphengine.control.desk import CommandDesk
    from graphengine.diagnostics import UsageError

    atexit.register(gc.freeze)  # the process ends with what it holds; to look through all of it takes a second
    _check_recording(arguments)
    assembly = assemble_to_run(arguments)
    if assembly is None:
        return 1
    if any(finding.code == "N102" for finding in assembly.findings.items):
        raise UsageError(f"{assembly.path} asks for prims of a scene; give one with --scene")
    network, domain_id = _open_network(arguments, assembly, lambda text: console.say("warning", "", text))
    console = Console(network)
    environment = domain_id if "ROS_DOMAIN_ID" in os.environ else None
    session = build.start(
        assembly,
        network,
        domain_id=domain_id,
        domain_from_environment=environment,
        log=console.say,
        fault=console.fault if arguments.keep_going else None,
    )
    session.desk = desk = CommandDesk()
    with (
        _Signals(session),
        _channel(arguments, desk, console),
        session,
        _recorder(arguments, assembly, session, network),
        _keys(session, console) as on_tick,
    ):
        graphs = counted(len(assembly.plans), "graph")
        what = f"{assembly.path}: {graphs}, {_rate_of(session):g} Hz; {network.description}"
        rays = assembly.loaded.simulation.rays_in_use if assembly.loaded is not None else ""
        what += (f"; rays {rays}" if rays else "") + (f"; recorded to {arguments.record}" if arguments.record else "")
        print(clean(what), file=sys.stderr)
        _offer_simulation_interfaces(arguments, desk, assembly, network)
        console.begin()
        factor = arguments.rate or (math.inf if arguments.transport == "memory" else 1.0)
        try:
            pace = None if math.isinf(factor) else factor
            session.run(arguments.duration, pace, on_tick, paused=arguments.paused)
        finally:
            console.summarize(session)
    return 0


def _check_recording(arguments: argparse.Namespace) -> None:
    """Refuse before anything is loaded what `--record` cannot mean.

    Raises:
        UsageError: a name that no reader of bags knows, a folder that is not there, or a file that is.
    """
    from graphengine.diagnostics import UsageError

    path: Path | None = arguments.record
    if path is None:
        return
    if path.suffix != ".mcap" or not path.parent.is_dir() or path.is_dir():
        raise UsageError(f"--record {path}: write the name of a file in a folder that is there, such as out.mcap")
    if path.exists() and not arguments.force:
        raise UsageError(f"--record {path}: already there; --force writes over it")


def _recorder(
    arguments: argparse.Namespace, assembly: Assembly, session: Session, network: LiveNetwork
) -> AbstractContextManager[object]:
    """What takes the run down, if that is wanted."""
    if arguments.record is None:
        return nullcontext()
    from graphengine.recording.recorder import Recorder

    return Recorder(
        session,
        network,
        assembly,
        arguments.record,
        force=arguments.force,
        keep_going=arguments.keep_going,
        modules=arguments.modules,
    )


def _channel(arguments: argparse.Namespace, desk: CommandDesk, console: Console) -> AbstractContextManager[object]:
    """Where `graphrun ctl` finds the run; the run goes on without, if that cannot be."""
    from graphengine.control.channel import Channel
    from graphengine.diagnostics import ControlError

    if arguments.no_control:
        return nullcontext()
    try:
        return Channel(desk, Path(arguments.file).stem, os.environ)
    except ControlError as error:
        console.say("warning", "", f"graphrun ctl cannot reach this run: {error}")
        return nullcontext()


@contextmanager
def _keys(session: Session, console: Console) -> Iterator[Callable[[Session], bool]]:
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

        def on_tick(session: Session) -> bool:
            keys.on_tick(session)
            return console.on_tick(session)

        yield on_tick


def _rate_of(session: Session) -> float:
    return 1.0 / session.clock.delta


def _open_network(
    arguments: argparse.Namespace, assembly: Assembly, complain: Callable[[str], None]
) -> tuple[LiveNetwork, int]:
    """The network on the domain that the environment names."""
    from dataclasses import replace

    from graphengine.ros.domain import Domain
    from graphengine.ros.network import LiveNetwork
    from graphengine.ros.select import open_transport

    domain, definitions = Domain.from_environment(os.environ), assembly.definitions
    name = re.sub(r"\A(?![A-Za-z])", "graph_", re.sub(r"[^A-Za-z0-9_]", "_", assembly.path.stem))

    def open_domain(number: int) -> Any:
        there = replace(domain, id=number)
        patient = arguments.rate is not None and math.isinf(arguments.rate)
        return open_transport(
            arguments.transport, there, name, environ=os.environ, definitions=definitions, patient=patient
        )

    return LiveNetwork(open_domain, domain.id, complain, definitions), domain.id


def _offer_simulation_interfaces(
    arguments: argparse.Namespace, desk: CommandDesk, assembly: Assembly, network: LiveNetwork
) -> None:
    """The services by which ROS 2 programs control simulators, if they are wanted, until the network is closed."""
    if arguments.simulation_interfaces:
        from graphengine.control.simulation_interfaces.server import SimulationInterfaces

        SimulationInterfaces(desk, assembly, network.transport(0), network.complain)


class _Signals:
    """Ctrl-C and SIGTERM end the run after the tick, or at once while it waits; a second one ends the process."""

    def __init__(self, session: Session) -> None:
        self.session = session
        self.before: dict[int, Any] = {}

    def __enter__(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            self.before[number] = signal.signal(number, self._stop)

    def _stop(self, number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_DFL)
        self.session.interrupt()

    def __exit__(self, *_: object) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)


class Console:
    """What a person sees of a run: a live line on a terminal, a plain line now and then elsewhere, a summary at the end."""

    LIVE, PLAIN = 0.25, 10.0  # seconds of wall time between two lines

    def __init__(self, network: LiveNetwork) -> None:
        self.network = network
        self.terminal = sys.stderr is not None and sys.stderr.isatty()
        self.said: set[tuple[str, str, str]] = set()
        self.faults = 0
        self.last_sent = 0
        self.last_ticks = 0
        self.last_line = ""
        self.begin()

    def begin(self) -> None:
        """The run begins, whose time and work count; that of setting everything up does not."""
        self.start = self.last = time.perf_counter()
        self.cpu_start = self.last_cpu = time.thread_time()

    def say(self, severity: str, node: str, message: str) -> None:
        """A node's message, once; what its first line says counts."""
        from graphengine.cli.common import clean

        key = (severity, node, message.partition("\n")[0])
        if key not in self.said:
            self.said.add(key)
            self._clear_line()
            print(clean(f"{severity}: {node + ': ' if node else ''}{message}"), file=sys.stderr)

    def fault(self, error: NodeError) -> None:
        """A node raised, and the run goes on."""
        from graphengine.cli.common import explain

        self.faults += 1
        self.say("error", "", explain(error))

    def on_tick(self, session: Session) -> bool:
        """Called after each tick, and while the run is paused; the run goes on."""
        for camera in session.services.world.dropped_pictures:
            self.say("warning", camera, LATE_PICTURE)
        now = time.perf_counter()
        if now - self.last >= (self.LIVE if self.terminal else self.PLAIN):
            self._show(self._line(session, now - self.last))
            self.last, self.last_cpu = now, time.thread_time()
            self.last_sent, self.last_ticks = self.network.sent, session.ticks
        return True

    def _line(self, session: Session, elapsed: float) -> str:
        """Where the run is, and how fast it was in the seconds since the last line."""
        ticks = session.ticks - self.last_ticks
        if not ticks and session.state != "playing":
            return f"t {session.time:9.2f} s   {session.state}"
        factor = ticks * session.clock.delta / elapsed
        tick = (time.thread_time() - self.last_cpu) / ticks if ticks else 0.0
        out = (self.network.sent - self.last_sent) / elapsed
        return (
            f"t {session.time:9.2f} s   real time x{factor:<6.2f} tick {tick * 1e3:6.2f} ms   out {out:6.0f} messages/s"
        )

    def _show(self, line: str) -> None:
        """Write over the line of a terminal; elsewhere a line that says the same is not repeated."""
        if self.terminal:
            print(f"\r{line[: self._columns()]}\x1b[K", end="", file=sys.stderr, flush=True)
        elif line != self.last_line:
            print(line, file=sys.stderr, flush=True)
        self.last_line = line

    def _columns(self) -> int | None:
        """How long a line may be that is to be written over: a wrapped one could not."""
        try:
            columns = os.get_terminal_size(sys.stderr.fileno()).columns
        except OSError:
            columns = 0
        return columns - 1 if columns else None

    def _clear_line(self) -> None:
        if self.terminal:
            print("\r\x1b[K", end="", file=sys.stderr)

    def summarize(self, session: Session) -> None:
        """What was done, and how fast."""
        from graphengine.cli.common import counted

        self._clear_line()
        wall = time.perf_counter() - self.start
        ticks, simulated = session.ticks, session.ticks * session.clock.delta
        tick = (time.thread_time() - self.cpu_start) / ticks if ticks else 0.0
        faults = f", {counted(self.faults, 'fault')}" if self.faults else ""
        for camera, number in session.services.world.dropped_pictures.items():
            print(f"came too late and dropped: {counted(number, 'picture')} of {camera}", file=sys.stderr)
        for topic, number in sorted(self.network.malformed.items()):
            print(f"malformed and dropped: {counted(number, 'message')} of {topic}", file=sys.stderr)
        for topic, number in sorted(self.network.overwritten.items()):
            print(f"overwritten before a tick took them: {counted(number, 'message')} of {topic}", file=sys.stderr)
        for topic, number in sorted(self.network.given_up.items()):
            print(
                f"given up on a reader that did not keep up: {counted(number, 'message')} of {topic}", file=sys.stderr
            )
        print(
            f"{counted(ticks, 'tick')}, {simulated:.3f} s of simulation in {wall:.3f} s (x{simulated / wall:.2f}), "
            f"{tick * 1e3:.3f} ms a tick, {counted(self.network.sent, 'message')}{faults}",
            file=sys.stderr,
        )
