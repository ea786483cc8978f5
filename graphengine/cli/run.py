"""`graphrun run`: run a scene or graph, connected to ROS 2."""

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
from graphengine.cli.options import add_flag, add_repeatable, add_value
from graphengine.cli.quantities import address, duration, rate
from graphengine.cli.terminal import wrapped

if TYPE_CHECKING:
    from graphengine.api.runner import Runner
    from graphengine.runtime.command_queue import CommandQueue
    from graphengine.runtime.session_core import SessionCore


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun run` to its parser."""
    from graphengine.cli.common import add_file_arguments, add_page_arguments, add_transport_argument

    add_file_arguments(parser)
    simulated = "simulation time to run, such as 10, 10s, 500ms or 2min (default: until Ctrl-C)"
    add_value(parser, "--for", "TIME", simulated, dest="duration", type=duration)
    pace = "realtime, max, or a factor of real time, such as 0.5 (default realtime; max with --transport memory)"
    parser.add_argument("--rate", type=rate, help=pace)
    add_flag(parser, "--paused", "start paused; `graphrun ctl play` starts the simulation")
    add_flag(parser, "--no-control", "disable `graphrun ctl` for this run")
    interfaces = (
        "offer the services of ROS 2's simulation_interfaces in this namespace (default /); everyone on the network can then"
        " stop, step and reset the run, and spawn and move robots; runs in the same ROS domain need different namespaces,"
        " such as /one"
    )
    add_value(parser, "--simulation-interfaces", "NAMESPACE", interfaces, nargs="?", type=_namespace, const="/")
    add_transport_argument(parser, reaching_others=False)
    add_flag(parser, "--no-parameters", "do not offer ROS parameters for inputs and variables")
    foxglove = (
        "serve all topics, for reading only, to Foxglove at ws://HOST:PORT (default host 127.0.0.1), in addition to"
        " --transport; Foxglove's SDK checks neither a password nor the origin of a page: all users and programs of this machine,"
        " including web pages in its browsers, can read the topics"
    )
    add_value(parser, "--foxglove", "[HOST:]PORT", foxglove, type=address)
    publish = (
        "let Foxglove clients also publish to the topics that graphs read, and so drive robots; the printed address then"
        " contains a token, and the port accepts only clients with this token"
    )
    add_flag(parser, "--foxglove-publish", publish)
    add_flag(parser, "--keep-going", "continue the run after an exception in a node; only the node's branch ends")
    bad = (
        "if a node cannot use a value from a wire or one that was set during the run: drop and count the value, or stop the"
        " run (default drop)"
    )
    parser.add_argument("--bad-values", choices=("drop", "stop"), default="drop", help=bad)
    record = (
        "record all inputs and outputs to an MCAP file for `graphrun replay`, ros2 bag and Foxglove; ticks then wait for"
        " camera images"
    )
    add_value(parser, "--record", "FILE", record, type=Path)
    lockstep = (
        "wait for a program, such as a controller on /clock: where each period of simulation time ends, the next tick begins when"
        " the program has sent its messages on the topic, as in /dd100_0000/cmd_vel=0.1s or /cmd_vel=0.1s,messages=2,timeout=10s"
        " (default: 1 message, 5s); replaces the topics of the scene's key `lockstep`"
    )
    add_repeatable(parser, "--lockstep", "TOPIC=PERIOD", lockstep, type=_lockstep)
    add_flag(parser, "--no-lockstep", "do not wait for programs, even if the scene has the key `lockstep`")
    ports = (
        "add the values of these ports to the recording and to Foxglove, as channels /_graph/ADDRESS; an address"
        " [ROBOT/][GRAPH/]NODE.PORT, whose parts may be globs, as in '*/ComputeOdom.*'"
    )
    add_repeatable(parser, "--ports", "ADDRESS", ports)
    profile = "print at the end how often each node ran and fired, and its computing time in every tenth tick"
    add_flag(parser, "--profile", profile)
    watch = (
        "reload files as soon as they are saved: nodes of changed graphs keep their state, and a changed world or robot"
        " restarts the run at t = 0; if the changed files have errors, the run continues with the previous version"
    )
    add_flag(parser, "--watch", watch)
    edit = (
        "let `graphrun ctl save` and the web page write values of inputs and positions of nodes into the YAML files of the"
        " scene's folder; not together with --view-host"
    )
    add_flag(parser, "--edit", edit)
    add_flag(parser, "--view", "serve a web page that shows and controls the run, and print its address")
    add_page_arguments(parser)
    add_flag(parser, "--view-read-only", "let the web page show the run, but not control it")
    quiet = "print only warnings, errors and losses, such as dropped messages; no status line, no summary"
    add_flag(parser, "--quiet", quiet)
    add_flag(parser, "--verbose", "also print why the transport was chosen, what it reaches, and how rays are cast")
    add_flag(parser, "--force", "let --record overwrite an existing file")


def _namespace(text: str) -> str:
    """Parse an absolute ROS 2 namespace.

    The error message explains the order of arguments, because the option takes a scene file behind it for its value.

    Raises:
        argparse.ArgumentTypeError: the text is not an absolute namespace.
    """
    from graphengine.format.errors import TopicError
    from graphengine.messages.names import check_namespace

    try:
        check_namespace(text)
    except TopicError as error:
        advice = "write a namespace, as in --simulation-interfaces /one; write the scene or graph before this option"
        raise argparse.ArgumentTypeError(f"{error.message}\n  {advice}") from None
    return text


def _lockstep(text: str) -> dict[str, Any]:
    """Parse an entry such as `/cmd_vel=0.1s,messages=2` to the keys of `lockstep` in a scene file."""
    parts = dict(pair.partition("=")[::2] for pair in f"topic={text.replace('=', ',period=', 1)}".split(","))
    return {key: int(value) if value.isdecimal() else value for key, value in parts.items()}


def execute(arguments: argparse.Namespace) -> int:
    """Run until the time `--for` has passed or a signal arrives; return 0, or 1 if the files have errors."""
    from graphengine.api.run_options import RunOptions, check_recording, read_lockstep
    from graphengine.api.scene import start_runner
    from graphengine.api.viewing import open_page
    from graphengine.cli.common import clean, open_scene
    from graphengine.format.errors import UsageError
    from graphengine.runtime.file_watch import FileWatch

    if arguments.record is not None:
        try:
            check_recording(arguments.record, force=arguments.force)
        except UsageError as error:
            raise UsageError(f"--record {error}") from None
    if arguments.foxglove_publish and arguments.foxglove is None:
        raise UsageError("--foxglove-publish needs --foxglove [HOST:]PORT")
    if arguments.edit and arguments.view_host not in ("127.0.0.1", "::1"):
        raise UsageError("--edit is only for pages on this machine: leave out --view-host")
    if arguments.ports and arguments.record is None and arguments.foxglove is None:
        raise UsageError("--ports needs --record FILE or --foxglove [HOST:]PORT")
    scene = open_scene(arguments)
    console = Console(quiet=arguments.quiet)
    options = RunOptions(
        transport=arguments.transport,
        keep_going=arguments.keep_going,
        bad_values=arguments.bad_values,
        record=arguments.record,
        force=arguments.force,
        simulation_interfaces=arguments.simulation_interfaces,
        foxglove=arguments.foxglove,
        foxglove_publish=arguments.foxglove_publish,
        parameters=not arguments.no_parameters,
        log=console.say,
        fault=console.fault,
        lockstep=read_lockstep(arguments.lockstep) if arguments.lockstep or arguments.no_lockstep else None,
        ports=arguments.ports,
        edit=arguments.edit,
        patient=arguments.rate is not None and math.isinf(arguments.rate),
    )
    runner = start_runner(scene, options)
    session = runner.session
    console.network = runner.network
    with (
        _signals(session),
        _channel(arguments, runner.queue, console),
        runner,
        _keys(session, console) as on_tick,
        _profiled(arguments, session, on_tick, console) as on_tick,
        FileWatch(session.reloader, runner.queue, console.reloaded) if arguments.watch else nullcontext(),
    ):
        for line in _opening(arguments, runner):
            console.inform(wrapped(clean(line), sys.stderr))
        if runner.foxglove:  # also if the console is quiet: the address may have a token
            console.tell(f"Foxglove at {runner.foxglove.url}")
        if arguments.view:
            host, port, watching = arguments.view_host, arguments.view_port, arguments.view_read_only
            try:
                open_page(runner, host, port, read_only=watching, served=lambda url: console.tell(f"see it: {url}"))
            except OSError as error:  # such as too many processes
                console.say("warning", "", f"the web page cannot be started: {error.strerror or error}")
        console.begin(session)
        try:
            runner.run(arguments.duration, arguments.rate, on_tick, paused=arguments.paused)
            session.end()
        finally:
            console.summarize(session)
    return 0


def _opening(arguments: argparse.Namespace, runner: Runner) -> Iterator[str]:
    """Yield the first lines of a run: scene, tick rate and transport; with `--verbose`, also numbers and details of both."""
    from graphengine.cli.common import counted
    from graphengine.ros.transport import brief

    loaded, session, transport = runner.scene, runner.session, runner.network.description
    yield f"{loaded.path.name}: {1.0 / session.clock.delta:g} Hz, {brief(transport)}"
    yield from runner.network.notices
    if arguments.record:
        yield f"recording to {arguments.record}"
    if arguments.verbose:
        yield f"{loaded.path}: {counted(len(loaded.planned), 'graph')}"
        yield transport
        if transport.startswith("dds "):
            yield "services, actions, parameters: with Cyclone DDS only; for other RMWs --transport rclpy"
        if rays := session.services.world.rays_in_use:
            yield f"rays {rays}"


def _channel(arguments: argparse.Namespace, queue: CommandQueue, console: Console) -> AbstractContextManager[object]:
    """Open and return the control channel for `graphrun ctl`.

    With `--no-control`, or if the channel cannot be opened, return a context manager without effect.
    """
    from graphengine.control.channel import Channel
    from graphengine.format.errors import ControlError

    if arguments.no_control:
        return nullcontext()
    try:
        return Channel(queue, Path(arguments.file).stem, os.environ)
    except ControlError as error:
        console.say("warning", "", f"graphrun ctl cannot reach this run: {error}")
        return nullcontext()


@contextmanager
def _keys(session: SessionCore, console: Console) -> Iterator[Callable[[SessionCore], bool]]:
    """Yield the function to call after each tick, which also passes keys of the terminal to graphs that use the keyboard."""
    terminal = sys.stdin is not None and sys.stdin.isatty()
    if not session.services.keys.asked or not terminal:
        if session.services.keys.asked:
            advice = "a graph uses the keyboard, but the standard input is not a terminal\n  use `graphrun ctl press W`"
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
    """Yield the function to call after each tick; with `--profile`, it measures the nodes, and a table is printed at the end."""
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


@contextmanager
def _signals(session: SessionCore) -> Iterator[None]:
    """Return a context manager in which Ctrl-C, SIGTERM and SIGHUP end a run after the tick, or at once if the run waits.

    A second signal with the same number ends the process. A SIGHUP that the process ignores, as under `nohup`, stays ignored.
    """

    def stop(number: int, frame: FrameType | None) -> None:
        signal.signal(number, signal.SIG_DFL)
        session.interrupt()

    hangup = [signal.SIGHUP] if signal.getsignal(signal.SIGHUP) != signal.SIG_IGN else []
    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM, *hangup)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
