"""Runs a session together with its network, recorder and control channel; only one thread at a time may use them."""

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

from graphengine.api.after_tick import AfterTick
from graphengine.api.diagnostics import MOST_FAULTS, Diagnostics
from graphengine.api.port_channels import PortChannels
from graphengine.api.run_options import RunOptions, check_recording
from graphengine.api.values import check_choice
from graphengine.format import interrupts
from graphengine.format.closing import Closing
from graphengine.format.errors import NodeError, RecordingError, StateError, UsageError
from graphengine.messages.checked_encoder import CheckedEncoder
from graphengine.messages.names import check_namespace
from graphengine.ros.domain import Domain
from graphengine.ros.lockstep import Lockstep
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transport import JoinOptions, Transport, Writer
from graphengine.ros.transports.select import AUTO, find_transport, open_transport
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.commands import parse
from graphengine.runtime.inbox import ExternalInputs
from graphengine.runtime.node_problems import NodeProblems
from graphengine.runtime.pacer import SLOWEST
from graphengine.runtime.port_values import PortValues
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import BadValues, LoadedScene

if TYPE_CHECKING:
    from graphengine.recording.recorder import Recorder
    from graphengine.ros.foxglove.foxglove_server import FoxgloveServer
    from graphengine.view.feed import Feed

T = TypeVar("T")


class Runner(Closing):
    """One session with its network and, if the options request them, its recorder and control channel.

    Args:
        scene: scene without errors.
        options: options of the session.
        modules: names of Python modules with node types; the recording stores these names.

    Raises:
        GraphError: a part of the session cannot start; all parts that were already started are closed.
    """

    def __init__(self, scene: LoadedScene, options: RunOptions, modules: Sequence[str] = ()) -> None:
        self.scene = scene
        self.options = options
        self.queue = CommandQueue()
        self.after_ticks: dict[object, AfterTick] = {}
        """What acts after each tick, oldest first: the user's periodic publications, and the sensors that the user reads."""
        self.writers: dict[object, Writer] = {}
        """Writers for messages that the user publishes, by topic, type and transport."""
        self.encoders: dict[str, CheckedEncoder] = {}
        """Encoders for messages that the user publishes, by type."""
        self.lock = threading.RLock()
        """Lock of the session; a thread holds it while it uses the session."""
        self.closed = self.running = self.cut_short = False
        """`running`: `run` or `step` executes ticks or callbacks; `cut_short`: a failed expectation has ended the last run."""
        self.recorder: Recorder | None = None
        self.feed: Feed | None = None
        """Feed that sends the session's state to the web page; None until the page is opened."""
        self.problems = NodeProblems()
        """Log and problems of nodes since the session was started; a web page that is opened later shows these too."""
        with ExitStack() as closing:
            self._check()
            own = Domain.from_environment(options.environ)
            domain = own if options.domain is None else replace(own, id=options.domain)
            self._complain = options.complain or functools.partial(options.log, "warning", "")
            self._faults: deque[str] = deque(maxlen=MOST_FAULTS)
            """Newest problems with other ROS 2 participants, such as incompatible QoS, for /diagnostics."""
            self.foxglove = self._open_foxglove(closing)
            """The Foxglove server of the session; None if the options do not request a server."""
            self.network = LiveNetwork(
                functools.partial(self._open_domain, domain), domain.id, self._take_peer_fault, scene.definitions
            )
            closing.callback(self.network.close)
            gate = Lockstep(self.network, build.lockstep_of(scene, options.lockstep))
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
            self.session.edits = options.edit
            self.session.queue, self.session.gate = self.queue, gate.opens
            self.problems.begin(self.session.services.dropped, lambda: self.session.time)
            closing.callback(self.session.close)
            self._ports = PortValues(self.session, options.ports) if options.ports else None
            self._port_channels: PortChannels | None = None
            if self.foxglove is not None and self._ports is not None:
                self._port_channels = closing.enter_context(PortChannels(self.foxglove, self._ports))
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
            raise UsageError(f"{self.scene.path} uses prims of a scene; give the scene with --scene")
        check_choice("bad_values", options.bad_values, get_args(BadValues))
        if options.simulation_interfaces is not None:
            check_namespace(options.simulation_interfaces)
        if options.record is not None:
            check_recording(options.record, force=options.force)

    def _open_domain(self, domain: Domain, number: int) -> Transport:
        options = self.options
        joined = JoinOptions(
            replace(domain, id=number),
            re.sub(r"\A(?![A-Za-z])", "graph_", re.sub(r"[^A-Za-z0-9_]", "_", self.scene.path.stem.strip("<>"))),
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
        address, publish = self.options.foxglove, self.options.foxglove_publish
        if address is None:
            return None
        from graphengine.ros.foxglove import open_server

        server = open_server(address, self.scene.path.stem, self.scene.definitions, publish=publish)
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
        self.problems.lines.add("warning", "", text)
        self._faults.append(text)

    def _open_diagnostics(self) -> Diagnostics | None:
        """Return a publisher of /diagnostics; None if messages do not leave the process."""
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

            self.recorder = Recorder(
                self.session,
                self.network,
                self.scene,
                self.options.record,
                force=self.options.force,
                keep_going=self.options.keep_going,
                modules=modules,
                ports=self._ports,
            )

    def _end_recording(self, error: BaseException | None = None) -> None:
        """Close the recording, if there is one; `error` is stored in it as the reason for its end."""
        recorder, self.recorder = self.recorder, None
        if recorder is not None:
            try:
                recorder.close(error)
            finally:
                self.network.sinks.remove(recorder)
                self.session.inbox = ExternalInputs()

    def _offer_simulation_interfaces(self) -> None:
        """Create the services of simulation_interfaces if the options request them; closing the network destroys them."""
        if self.options.simulation_interfaces is not None:
            from graphengine.control.simulation_interfaces.server import SimulationInterfaces

            transport, namespace = self.network.transport(0), self.options.simulation_interfaces
            scenery = self.scene.world.scenery if self.scene.world is not None else None
            scene = (scenery.scene, scenery.library.files) if scenery is not None else None
            SimulationInterfaces(self.queue, scene, transport, self._complain, namespace=namespace)

    def _offer_parameters(self, closing: ExitStack) -> None:
        """Create the ROS parameters of the session and its robots, if requested and if the transport has a ROS node."""
        transport = self.network.transport(0)
        if self.options.parameters and transport.node:
            from graphengine.control.parameters import ParameterNodes

            closing.callback(ParameterNodes(self.session, self.queue, transport, self._complain).close)

    def enter(self) -> None:
        """Acquire `lock` for this thread without waiting; the same thread has to release it.

        Raises:
            StateError: another thread holds the lock.
        """
        if not self.lock.acquire(blocking=False):
            raise StateError(
                "another thread uses this session; only submit and interrupt may be called from any thread"
            )

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Execute a command of `runtime.commands` immediately and return its result.

        Raises:
            UsageError: the arguments are invalid.
        """
        return self.act(parse(name, arguments).apply)

    def act(self, action: Callable[[SessionCore], T]) -> T:
        """Execute an action between two ticks and return its result; if the action cannot be recorded, close the recording."""
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
        first: Callable[[SessionCore], bool] | None = None,
        paused: bool = False,
    ) -> bool:
        """Play for a duration in simulation time, then pause.

        Ctrl-C ends the run between two ticks, unless the program has its own SIGINT handler.

        Args:
            seconds: duration in simulation time, s; None or infinity plays without end.
            rate: seconds of simulation per second of wall time; infinity plays as fast as possible. None plays as fast as
                possible with the transport `memory`, and in real time with other transports.
            on_tick: called after each tick; returning False ends the run.
            first: called before the first tick; if it returns False, no tick is run.
            paused: whether the run begins paused.

        Returns:
            Whether the whole duration passed.
        """
        factor = rate if rate is not None else 1.0 if self._reaches_others() else math.inf
        if not factor >= SLOWEST:
            raise UsageError(
                f"rate: expected at least {SLOWEST:g} seconds of simulation per second of wall time, got {rate!r}"
            )
        if seconds is not None and not seconds >= 0.0:
            raise UsageError(f"seconds: expected a duration of 0 s or more, got {seconds!r}")
        ends = None if seconds is None or math.isinf(seconds) else seconds

        def after_tick(session: SessionCore) -> bool:
            self._after_tick()
            return on_tick is None or on_tick(session)

        with self._ticking():
            if first is not None and not first(self.session):
                self.session.interrupted = False
                return False
            self.session.run(ends, None if math.isinf(factor) else factor, after_tick, paused=paused)
        return self.session.ticks >= self.session.last

    def step(self, ticks: int) -> None:
        """Run a number of ticks as fast as possible; Ctrl-C ends the call between two ticks."""
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
        for action in tuple(self.after_ticks.values()):
            action.after_tick(self.session.clock.frame)
        if self._diagnostics is not None:
            self._diagnostics.after_tick()
        if self._port_channels is not None:
            self._port_channels.after_tick(self.session.ticks)
        if self.feed is not None:
            self.feed.after_tick()

    def show(self, feed: Feed) -> None:
        """Update a web page after each tick from now on; the page is closed with the session."""
        self.feed = feed
        self._closing.callback(feed.close)

    @contextmanager
    def _ticking(self) -> Iterator[None]:
        """Enclose the execution of ticks: nested runs raise StateError, and Ctrl-C ends the run after the current tick.

        A second Ctrl-C raises KeyboardInterrupt immediately. If the program has its own SIGINT handler, Ctrl-C is left to it.
        """
        if self.running:
            raise StateError("the session is running: `until` and other callbacks must not run ticks")
        self.running, self.cut_short, pressed, error = True, False, False, None

        def end(number: int, frame: FrameType | None) -> None:
            nonlocal pressed
            if pressed:
                interrupts.interrupt(number, frame)
            pressed = True
            self.session.interrupt()

        before = signal.getsignal(signal.SIGINT)
        own = threading.current_thread() is threading.main_thread()
        handles = own and before in (signal.default_int_handler, interrupts.interrupt)
        if handles:
            signal.signal(signal.SIGINT, end)
        try:
            yield
        except BaseException as raised:
            error = raised
            raise
        finally:
            if handles:
                signal.signal(signal.SIGINT, before)
            self.running = False
            self._end_run(error)
            if pressed:
                self.session.interrupted = False
                if error is None:
                    raise KeyboardInterrupt

    def _end_run(self, error: BaseException | None) -> None:
        """Pause the session and update the web page; after an error of the session or the recording, close the recording."""
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
            StateError: the session is running, or another thread uses the session.
        """
        self.enter()
        try:
            if self.running:
                raise StateError("the session is running: `until` and other callbacks must not close the session")
            self.closed = True
            self._closing.close()
        finally:
            self.lock.release()
