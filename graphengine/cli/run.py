"""`graphrun run`: a scene or graph, live on the network."""

from __future__ import annotations

import argparse
import math
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

from graphengine.cli.console import Console
from graphengine.cli.units import duration, rate

if TYPE_CHECKING:
    from graphengine.ros.network import LiveNetwork
    from graphengine.runtime.desk import Desk
    from graphengine.runtime.session import Session
    from graphengine.scene.scene import Scene


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
    from graphengine.cli.common import clean, counted, load_to_run
    from graphengine.format.errors import UsageError
    from graphengine.runtime.desk import Desk
    from graphengine.scene import build

    _check_recording(arguments)
    scene = load_to_run(arguments)
    if scene is None:
        return 1
    if any(finding.code == "N102" for finding in scene.findings.items):
        raise UsageError(f"{scene.path} asks for prims of a scene; give one with --scene")
    network, domain_id = _open_network(arguments, scene, lambda text: console.say("warning", "", text))
    console = Console(network)
    environment = domain_id if "ROS_DOMAIN_ID" in os.environ else None
    session = build.start(
        scene,
        network,
        domain_id=domain_id,
        domain_from_environment=environment,
        log=console.say,
        fault=console.fault if arguments.keep_going else None,
        bad_values=arguments.bad_values,
    )
    session.desk = desk = Desk()
    with (
        _Signals(session),
        _channel(arguments, desk, console),
        session,
        _recorder(arguments, scene, session, network),
        _keys(session, console) as on_tick,
    ):
        graphs = counted(len(scene.planned), "graph")
        what = f"{scene.path}: {graphs}, {1.0 / session.clock.delta:g} Hz; {network.description}"
        rays = session.services.world.rays_in_use
        what += (f"; rays {rays}" if rays else "") + (f"; recorded to {arguments.record}" if arguments.record else "")
        console.tell(clean(what))
        _offer_simulation_interfaces(arguments, desk, scene, network)
        console.begin()
        factor = arguments.rate or (math.inf if arguments.transport == "memory" else 1.0)
        try:
            pace = None if math.isinf(factor) else factor
            session.run(arguments.duration, pace, on_tick, paused=arguments.paused)
            session.end()
        finally:
            console.summarize(session)
    return 0


def _check_recording(arguments: argparse.Namespace) -> None:
    """Refuse before anything is loaded what `--record` cannot mean.

    Raises:
        UsageError: a name that no reader of bags knows, a folder that is not there, or a file that is.
    """
    from graphengine.format.errors import UsageError

    path: Path | None = arguments.record
    if path is None:
        return
    if path.suffix != ".mcap" or not path.parent.is_dir() or path.is_dir():
        raise UsageError(f"--record {path}: write the name of a file in a folder that is there, such as out.mcap")
    if path.exists() and not arguments.force:
        raise UsageError(f"--record {path}: already there; --force writes over it")


def _recorder(
    arguments: argparse.Namespace, scene: Scene, session: Session, network: LiveNetwork
) -> AbstractContextManager[object]:
    """What takes the run down, if that is wanted."""
    if arguments.record is None:
        return nullcontext()
    from graphengine.recording.recorder import Recorder

    return Recorder(
        session,
        network,
        scene,
        arguments.record,
        force=arguments.force,
        keep_going=arguments.keep_going,
        modules=arguments.modules,
    )


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


def _open_network(
    arguments: argparse.Namespace, scene: Scene, complain: Callable[[str], None]
) -> tuple[LiveNetwork, int]:
    """The network on the domain that the environment names."""
    from dataclasses import replace

    from graphengine.ros.domain import Domain
    from graphengine.ros.network import LiveNetwork
    from graphengine.ros.transports.select import open_transport

    domain, definitions = Domain.from_environment(os.environ), scene.definitions
    name = re.sub(r"\A(?![A-Za-z])", "graph_", re.sub(r"[^A-Za-z0-9_]", "_", scene.path.stem))

    def open_domain(number: int) -> Any:
        there = replace(domain, id=number)
        patient = arguments.rate is not None and math.isinf(arguments.rate)
        return open_transport(
            arguments.transport,
            there,
            name,
            arguments.simulation_interfaces or "/",
            environ=os.environ,
            definitions=definitions,
            patient=patient,
        )

    return LiveNetwork(open_domain, domain.id, complain, definitions), domain.id


def _offer_simulation_interfaces(arguments: argparse.Namespace, desk: Desk, scene: Scene, network: LiveNetwork) -> None:
    """The services by which ROS 2 programs control simulators, if they are wanted, until the network is closed."""
    if arguments.simulation_interfaces is not None:
        from graphengine.control.simulation_interfaces.server import SimulationInterfaces

        SimulationInterfaces(
            desk, scene, network.transport(0), network.complain, namespace=arguments.simulation_interfaces
        )


class _Signals:
    """Ctrl-C, SIGTERM and a terminal that is closed end the run after the tick, or at once while it waits.

    A second one ends the process. What a run under `nohup` is to outlive it goes on outliving.
    """

    def __init__(self, session: Session) -> None:
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
