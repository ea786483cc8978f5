"""A running session with its network, recorder and control channel, and the rules on which thread may call it."""

from __future__ import annotations

import functools
import math
import re
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from types import FrameType
from typing import TYPE_CHECKING, Any, TypeVar, get_args

from graphengine.api.diagnostics import MOST_FAULTS, Diagnostics
from graphengine.api.run_options import RunOptions, check_recording
from graphengine.format.errors import NodeError, RecordingError, StateError, UsageError
from graphengine.format.wording import listing
from graphengine.messages.names import check_namespace
from graphengine.node.dropped_values import BadValues
from graphengine.ros.domain import Domain
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions, Transport, Writer
from graphengine.ros.transports.select import AUTO, find_transport, open_transport
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.commands import parse
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import LoadedScene
from graphengine.view.node_problems import NodeProblems

if TYPE_CHECKING:
    from graphengine.api.topics import Publication
    from graphengine.recording.recorder import Recorder
    from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
    from graphengine.view.feed import Feed

T = TypeVar("T")


class Runner:
    """One session with its network and, if asked for, its recorder and control channel.

    Args:
        scene: scene without errors.
        options: options of the session.
        modules: Python modules with node types; the recording stores their names.

    Raises:
        GraphError: a part of the session cannot start; the parts already started are closed.
    """

    def __init__(self, scene: LoadedScene, options: RunOptions, modules: Sequence[str] = ()) -> None:
        self.scene = scene
        self.options = options
        self.queue = CommandQueue()
        self.publications: dict[Publication, None] = {}
        """Periodic publications, in the order of their start."""
        self.writers: dict[object, Writer] = {}
        """Writers of the user's messages, by topic, type and transport."""
        self.lock = threading.RLock()
        """Held by the thread that uses the session."""
        self.closed = False
        self.running = False
        """Whether ticks or the condition `until` are being executed."""
        self._recorder: Recorder | None = None
        self.feed: Feed | None = None
        """Feed of the page, if there is one."""
        self.problems = NodeProblems()
        """Problems of nodes since the start, which a page shows that is opened later."""
        with ExitStack() as closing:
            self._check()
            own = Domain.from_environment(options.environ)
            domain = own if options.domain is None else replace(own, id=options.domain)
            self._complain = options.complain or functools.partial(options.log, "warning", "")
            self._faults: deque[str] = deque(maxlen=MOST_FAULTS)
            """The newest faults of peers, for /diagnostics."""
            self.foxglove = self._open_foxglove(closing)
            """The server that shows the session to Foxglove, if asked for."""
            self.network = LiveNetwork(
                functools.partial(self._open_domain, domain), domain.id, self._take_peer_fault, scene.definitions
            )
            closing.callback(self.network.close)
            self._open_channel(closing)
            closing.callback(self.queue.close, "the run has ended")
            self.session = build.start(
                scene,
                self.network,
                seed=options.seed,
                domain_id=domain.id,
                domain_from_environment=own.id if "ROS_DOMAIN_ID" in options.environ else None,
                log=self._log,
                fault=self._take_fault if options.keep_going else None,
                bad_values=options.bad_values,
            )
            self.session.queue = self.queue
            self.problems.dropped = self.session.services.dropped
            closing.callback(self.session.close)
            self._open_recorder(modules)
            closing.callback(self._end_recording)
            self._offer_simulation_interfaces()
            self._offer_parameters(closing)
            self._diagnostics = self._open_diagnostics()
            self._closing = closing.pop_all()

    def _check(self) -> None:
        """Raise UsageError for invalid options."""
        options = self.options
        if any(finding.code == "N102" for finding in self.scene.findings.items):
            raise UsageError(f"{self.scene.path} uses prims of a scene; give one with --scene")
        if options.bad_values not in get_args(BadValues):
            raise UsageError(f"bad_values: unknown value {options.bad_values!r}; {listing(get_args(BadValues))}")
        if options.simulation_interfaces is not None:
            check_namespace(options.simulation_interfaces)
        if options.record is not None:
            check_recording(options.record, force=options.force)

    def _open_domain(self, domain: Domain, number: int) -> Transport:
        options = self.options
        joined = JoinOptions(
            replace(domain, id=number),
            re.sub(r"\A(?![A-Za-z])", "graph_", re.sub(r"[^A-Za-z0-9_]", "_", self.scene.path.stem)),
            options.simulation_interfaces or "/",
            options.environ,
            self.scene.definitions,
            patient=options.patient,
        )
        join = options.join or functools.partial(open_transport, options.transport)
        transport = join(joined)
        if self.foxglove is None:
            return transport
        from graphengine.ros.foxglove.foxglove_transport import FoxgloveTransport

        return FoxgloveTransport(transport, self.foxglove)

    def _reaches_others(self) -> bool:
        name = self.options.transport
        return self.foxglove is not None or name == AUTO or find_transport(name).reaches_others

    def _open_foxglove(self, closing: ExitStack) -> FoxgloveServer | None:
        if self.options.foxglove is None:
            return None
        from graphengine.ros.foxglove import open_server

        server = open_server(self.options.foxglove, self.scene.path.stem, self.scene.definitions)
        closing.callback(server.close)
        return server

    def _log(self, severity: str, node: str, text: str) -> None:
        self.options.log(severity, node, text)
        self.problems.log(severity, node, text)

    def _take_fault(self, error: NodeError) -> None:
        if self.options.fault is not None:
            self.options.fault(error)
        else:
            self.options.log("error", "", str(error))
        self.problems.add(error.node, str(error))

    def _take_peer_fault(self, text: str) -> None:
        self._complain(text)
        self._faults.append(text)

    def _open_diagnostics(self) -> Diagnostics | None:
        """Open /diagnostics, unless messages stay in the process."""
        if not self._reaches_others():
            return None
        return Diagnostics(self.session, self.network, self.scene.path.stem, self._faults)

    def _open_channel(self, closing: ExitStack) -> None:
        if self.options.control is not None:
            from graphengine.control.channel import Channel

            closing.enter_context(Channel(self.queue, self.options.control, self.options.environ))

    def _open_recorder(self, modules: Sequence[str]) -> None:
        if self.options.record is not None:
            from graphengine.recording.recorder import Recorder

            self._recorder = Recorder(
                self.session,
                self.network,
                self.scene,
                self.options.record,
                force=self.options.force,
                keep_going=self.options.keep_going,
                modules=modules,
            )

    def _end_recording(self, error: BaseException | None = None) -> None:
        """Close the recording, and store the error that ended it."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            try:
                recorder.close(error)
            finally:
                self.network.sinks.remove(recorder)
                self.session.inbox = ExternalInputs()

    def _offer_simulation_interfaces(self) -> None:
        """Offer the services of simulation_interfaces until the network is closed."""
        if self.options.simulation_interfaces is not None:
            from graphengine.control.simulation_interfaces.server import SimulationInterfaces

            transport, namespace = self.network.transport(0), self.options.simulation_interfaces
            SimulationInterfaces(self.queue, self.scene, transport, self._complain, namespace=namespace)

    def _offer_parameters(self, closing: ExitStack) -> None:
        """Offer the parameters of the session and its robots, unless messages stay in this process."""
        transport = self.network.transport(0)
        if self.options.parameters and transport.node:
            from graphengine.control.parameters import ParameterNodes

            closing.callback(ParameterNodes(self.session, self.queue, transport, self._complain).close)

    # Who may call it, and when

    def enter(self) -> None:
        """Acquire `lock` for this thread without waiting; the same thread has to release it.

        Raises:
            StateError: another thread has it.
        """
        if not self.lock.acquire(blocking=False):
            raise StateError(
                "another thread uses this session; only submit and interrupt may be called from any thread"
            )

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Execute a command of `runtime.commands` immediately.

        Raises:
            UsageError: the arguments are invalid.
        """
        return self.act(parse(name, arguments).apply)

    def act(self, action: Callable[[SessionCore], T]) -> T:
        """Execute an action between two ticks and record it."""
        try:
            return action(self.session)
        except RecordingError as error:  # it was done, and the run cannot be recorded any more
            self._end_recording(error)
            raise

    def run(
        self,
        seconds: float | None,
        rate: float | None,
        on_tick: Callable[[SessionCore], bool] | None = None,
        *,
        paused: bool = False,
    ) -> bool:
        """Play for a duration in simulation time, then pause; arguments as for `SessionCore.run`.

        Ctrl-C ends it between two ticks, unless the program has a SIGINT handler.

        Args:
            seconds: duration, s of simulation; None or infinity plays without end.
            rate: seconds of simulation per second of wall time; infinity plays as fast as possible; None does so with the
                transport memory, and plays in real time with others.
            on_tick: called after each tick; returning False ends the run.
            paused: start paused.

        Returns:
            Whether the whole duration passed.
        """
        factor = rate if rate is not None else 1.0 if self._reaches_others() else math.inf
        if not factor >= SLOWEST:
            raise UsageError(f"rate: expected a factor of real time, at least {SLOWEST:g}, got {rate!r}")
        if seconds is not None and not seconds >= 0.0:
            raise UsageError(f"seconds: expected a time that is not negative, got {seconds!r}")
        ends = None if seconds is None or math.isinf(seconds) else seconds

        def after_tick(session: SessionCore) -> bool:
            self._after_tick()
            return on_tick is None or on_tick(session)

        with self._ticking():
            self.session.run(ends, None if math.isinf(factor) else factor, after_tick, paused=paused)
        return self.session.ticks >= self.session.last

    def step(self, ticks: int) -> None:
        """Run a number of ticks as fast as possible; Ctrl-C ends it between two ticks."""
        with self._ticking():
            self.session.services.world.realtime = False
            for _ in range(ticks):
                self.queue.serve(self.session)
                if self.session.interrupted:
                    self.session.interrupted = False
                    break
                self.session.step()
                self._after_tick()

    def _after_tick(self) -> None:
        for publication in tuple(self.publications):
            publication.after_tick(self.session.clock.frame)
        if self._diagnostics is not None:
            self._diagnostics.after_tick()
        if self.feed is not None:
            self.feed.after_tick()

    def show(self, feed: Feed) -> None:
        """Set the web page to update after each tick; the page is closed with the session."""
        self.feed = feed
        self._closing.callback(feed.close)

    @contextmanager
    def _ticking(self) -> Iterator[None]:
        """Prepare for ticks: reject nested runs, and let the first Ctrl-C end the run after the current tick.

        A second Ctrl-C raises KeyboardInterrupt immediately. A SIGINT handler of the program stays in place.
        """
        if self.running:
            raise StateError("the session is running: `until` must not run ticks")
        self.running, pressed, error = True, False, None

        def end(number: int, frame: FrameType | None) -> None:
            nonlocal pressed
            if pressed:
                raise KeyboardInterrupt
            pressed = True
            self.session.interrupt()

        own = threading.current_thread() is threading.main_thread()
        handles = own and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if handles:
            signal.signal(signal.SIGINT, end)
        try:
            yield
        except BaseException as raised:
            error = raised
            raise
        finally:
            if handles:
                signal.signal(signal.SIGINT, signal.default_int_handler)
            self.running = False
            self._end_run(error)
            if pressed:
                self.session.interrupted = False
                if error is None:
                    raise KeyboardInterrupt

    def _end_run(self, error: BaseException | None) -> None:
        """Pause after ticks, and close the recording after an error that ends the run."""
        if error is not None and (self.session.state == "failed" or isinstance(error, RecordingError)):
            self._end_recording(error)
        if self.session.state == "playing":
            self.session.pause()
        if self.feed is not None:
            self.feed.end_run(error)

    def close(self) -> None:
        """Close the session, then the recording and the network; safe to call twice.

        Raises:
            RecordingError: the recording cannot be written.
            StateError: the session is running, or another thread uses it.
        """
        self.enter()
        try:
            if self.running:
                raise StateError("the session is running: `until` must not close it")
            self.closed = True
            self._closing.close()
        finally:
            self.lock.release()

    def __enter__(self) -> Runner:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
