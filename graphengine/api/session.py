"""The class `Session`: a running scene whose values programs read and change between two ticks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar, overload

from graphengine.api.after_tick import AfterTick
from graphengine.api.calls import Goal, ServiceCall, call_service
from graphengine.api.checks import Check
from graphengine.api.guards import acting, reading
from graphengine.api.output_digest import OutputDigest
from graphengine.api.runner import Runner
from graphengine.api.session_world import SessionWorld
from graphengine.api.topics import M, MessageType, Publication, Subscription, open_subscription
from graphengine.api.value_records import ValueRecord
from graphengine.api.values import plain, read_only
from graphengine.format.errors import ExpectationError, UsageError
from graphengine.format.wording import did_you_mean, listing
from graphengine.runtime.addresses import NodePort, find_port_at, find_ports

C = TypeVar("C", bound=Check)
A = TypeVar("A", bound=AfterTick)


class Session(SessionWorld):
    """A running scene: one world, one network, and the state of every node. `Scene.session` starts it.

    Times are in simulation time, s; lengths in m, angles in rad, forces in N. Poses and velocities are in the world frame;
    quaternions are (x, y, z, w). Changes take effect in the next tick. Arrays are read-only views; copy an array to keep it.

    Use a session from one thread at a time. Only `submit` and `interrupt` may be called from any thread; other concurrent
    calls raise StateError. After a NodeError or PhysicsError, the state is `failed`: values can be read, but methods that
    change the session raise StateError until `reset` or `restore` is called.

    >>> with ge.load("dd100_flat").session() as sim:
    ...     drive = sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
    ...     sim.run(2.0)
    ...     sim.robots["dd100"].pose.position[0] > 0.5
    True
    True
    """

    def __init__(self, runner: Runner) -> None:
        super().__init__(runner)
        self._graphs: object = None
        self._ports: dict[str, NodePort] = {}
        """Cache of `value`: ports of `_graphs` by the address that the caller gave."""
        self._checks: list[Check] = []

    # Values of nodes

    @reading
    def value(self, address: str) -> Any:
        """Return the value of a port, in the port's Python type; an array is a read-only view that later ticks may change.

        >>> sim.value("dd100/joint_states/ComputeOdom.position")
        (0.0, 0.0, 0.0)

        Args:
            address: `[robot/][graph/][subgraph/…]Node.[inputs:|outputs:|state:]port`; the optional parts are needed only
                if several ports match. Without `inputs:`, `outputs:` or `state:`, outputs are searched before inputs.

        Raises:
            UsageError: no port or several ports match the address.
        """
        return self._port_value(address)

    def _port_value(self, address: str) -> Any:
        graphs = self._runner.session.graphs
        if self._graphs is not graphs:
            self._graphs, self._ports = graphs, {}
        if address not in self._ports:
            self._ports[address] = find_port_at(graphs, address)
        return read_only(self._ports[address].value)

    @reading
    def values(self, pattern: str) -> dict[str, Any]:
        """Return the values of all matching ports, by address.

        >>> sim.values("*/joint_states/ComputeOdom.position")
        {'dd100/joint_states/ComputeOdom.position': (0.0, 0.0, 0.0)}

        Args:
            pattern: address as in `value`; each part can be a glob pattern, such as `*`. `*` alone lists all ports.

        Raises:
            UsageError: no port matches.
        """
        return {port.address: read_only(port.value) for port in find_ports(self._runner.session.graphs, pattern)}

    @acting
    def set(self, address: str, value: Any) -> None:
        """Set unwired inputs to a value, which the inputs keep through `reset`. A recording stores the call.

        >>> sim.set("dd100/cmd_vel/DiffController.maxLinearSpeed", 1.0)

        Args:
            address: `[robot/][graph/]Node.port`; each part can be a glob pattern.
            value: value as in a graph file; all matching inputs get this value.

        Raises:
            UsageError: no input matches, a matching input is wired, or the value has another type or is out of the bounds of the
                port. No input has changed.
        """
        self._runner.command("set", address=address, value=plain(value))

    @reading
    def variables(self, graph: str) -> dict[str, Any]:
        """Return the values of a graph's variables by name; the name of a subgraph's variable is `subgraph/name`.

        >>> sim.variables("dd100/cmd_vel")
        {}

        Args:
            graph: name of the graph, `robot/graph` for a robot's graph; `robot/` can be left out if the rest is unique.

        Raises:
            UsageError: no graph or several graphs match the name.
        """
        runs = {run.name: run for run in self._runner.session.graphs}
        meant = [name for name in runs if name == graph] or [name for name in runs if name.endswith(f"/{graph}")]
        if len(meant) != 1:
            near = listing(meant, "write one of") if meant else did_you_mean(graph, runs) or listing(runs, "graphs")
            raise UsageError(f"{f'{len(meant)} graphs match' if meant else 'no graph matches'} {graph!r}\n  {near}")
        return {name: read_only(variable.value) for name, variable in runs[meant[0]].variables.items()}

    # Expectations

    @overload
    def expect(self, begin: Callable[[Session], C], /) -> C: ...
    @overload
    def expect(self, *begin: Callable[[Session], C]) -> tuple[C, ...]: ...
    def expect(self, *begin: Callable[[Session], Any]) -> Any:
        """Judge expectations after each tick from now on; return the check, or a tuple of checks for several expectations.

        >>> slow = sim.expect(ge.always("port('dd100/joint_states/ComputeOdom.position')[0] < 0.5"))
        >>> sim.run(1.0, until=sim.decided)
        False
        >>> slow.outcome
        'open'

        Args:
            begin: expectations such as `ge.always(…)`, or other functions that return a check of a session.

        Raises:
            UsageError: a condition of an expectation is not legal, or names something that the session does not have.
        """
        checks = self._judge(begin)
        return checks[0] if len(checks) == 1 else checks

    @acting
    def _judge(self, begin: Sequence[Callable[[Session], Check]]) -> tuple[Check, ...]:
        checks = tuple(start(self) for start in begin)
        for check in checks:
            check.begin(self._runner.after_ticks)
        self._checks.extend(checks)
        return checks

    @reading
    def mark(self, text: str) -> None:
        """Add a mark to the recording at this tick, which the page shows on its time bar; do nothing without a recording.

        >>> sim.mark("the pallet is in view")
        """
        if self._runner.recorder is not None:
            self._runner.recorder.mark(text)

    def decided(self, _: object = None) -> bool:
        """Return whether all expectations are decided or one has failed; pass this method to `run` as `until`.

        >>> drives = sim.expect(ge.within(5.0, "velocity('dd100').linear[0] > 0.4"))
        >>> drive = sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        >>> sim.run(10.0, until=sim.decided)
        True
        """
        outcomes = {check.outcome for check in self._checks}
        failed = bool(outcomes & {"failed", "error"})
        self._runner.cut_short = failed
        return failed or (bool(outcomes) and "open" not in outcomes)

    def judge(self) -> None:
        """End and remove all expectations, and raise an error if one is not met.

        Open expectations are decided now, unless a failure has just ended the run early by `until=sim.decided`.

        >>> check = sim.expect(ge.always("tilt('dd100') < 0.1"))
        >>> sim.run(1.0)
        True
        >>> sim.judge()

        Raises:
            ExpectationError: an expectation is not met or could not be judged; the message reports all of these.
        """
        self.end_expectations()
        judged, self._checks = self._checks, []
        missed = [check.report() for check in judged if check.outcome in ("failed", "error")]
        if missed:
            raise ExpectationError("\n".join(missed))

    @reading
    def end_expectations(self) -> None:
        """Decide all expectations that are open, unless a failure has ended the run early by `until=sim.decided`.

        >>> check = sim.expect(ge.always("time < 9"))
        >>> sim.run(0.1)
        True
        >>> sim.end_expectations()
        >>> check.outcome
        'passed'
        """
        for check in self._checks:
            if not self._runner.cut_short:
                check.end()
            check.stop(self._runner.after_ticks)

    # Measurements

    @acting
    def measure(self, begin: Callable[[Session], A]) -> A:
        """Compute a metric from one sample per tick from now on; `value` of the returned measurement is the metric.

        >>> top_speed = sim.measure(ge.metric(max="velocity('dd100').linear[0]"))
        >>> drive = sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        >>> sim.run(2.0)
        True
        >>> 0.45 < top_speed.value < 0.55
        True

        Args:
            begin: a metric such as `ge.metric(max=…)`, or another function that returns an object to call after each tick.

        Raises:
            UsageError: the expression of the metric is not legal, or names something that the session does not have.
        """
        measurement = begin(self)
        self._runner.after_ticks[measurement] = measurement
        return measurement

    @acting
    def digest_output(self, *, everything: bool = False) -> OutputDigest:
        """Hash all messages that nodes publish from now on; `value` of the returned digest covers the messages so far.

        Equal files, seeds and calls give equal digests in all processes.

        >>> output, odom = sim.digest_output(), sim.subscribe("/dd100_0000/odom")
        >>> sim.step()
        >>> len(output.value)
        32

        Args:
            everything: whether nodes publish on all topics, as in a recorded run; otherwise they publish only on topics that are
                latched or have subscribers.
        """
        return OutputDigest(self._runner.network, everything)

    # Topics and services

    @overload
    def subscribe(self, topic: str, type: type[M], keep: int = 1000) -> Subscription[M]: ...
    @overload
    def subscribe(self, topic: str, type: str | None = None, keep: int = 1000) -> Subscription[Any]: ...
    def subscribe(self, topic: str, type: MessageType = None, keep: int = 1000) -> Subscription[Any]:
        """Subscribe to a topic. Nodes that publish only on topics with subscribers then publish on this topic.

        >>> odom = sim.subscribe("/dd100_0000/odom")
        >>> sim.step()
        >>> odom.latest.header.frame_id
        'odom'

        Args:
            topic: full name of the topic.
            type: message type: its name, or its class in `graphengine.messages.messages`; needed if no graph uses the topic.
            keep: number of newest messages to keep; if the messages are images, a small number saves memory.

        Raises:
            UsageError: no graph uses the topic and `type` is missing, or the graphs use another type.
        """
        return open_subscription(self, topic, type, keep)

    @acting
    def record_values(self, *addresses: str) -> ValueRecord:
        """Collect the values of ports after each tick, as arrays.

        >>> record = sim.record_values("*/joint_states/ComputeOdom.position")
        >>> sim.run(0.5)
        True
        >>> record.times.shape, record["dd100/joint_states/ComputeOdom.position"].shape
        ((30,), (30, 3))

        Args:
            addresses: addresses of ports as in `value`; their parts may be globs.

        Raises:
            UsageError: no port matches an address, or none of the ports has a number, a text or a short array.
        """
        return ValueRecord(self._runner, addresses)

    @acting
    def publish(self, topic: str, message: Any, every: float | None = None, type: MessageType = None) -> Publication:
        """Publish a message once or periodically. A recording stores it like a message from another program.

        >>> drive = sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        >>> sim.run(1.0)
        True
        >>> drive.close()

        Args:
            topic: full name of the topic.
            message: mapping of fields, or a message of `graphengine.messages.messages`. With the transport `memory`, the
                message arrives in the next tick.
            every: period in simulation time, s; the message is sent until the publication is closed. None sends it once.
            type: message type, by name or class; needed if no graph uses the topic.

        Raises:
            MessageError: the message does not match its type.
            UsageError: no graph uses the topic and `type` is missing, or the graphs use another type.
        """
        return Publication(self._runner, topic, message, every, type)

    @acting
    def call(self, service: str, request: Any, timeout: float = 5.0, type: str | None = None) -> Any:
        """Call a service, run ticks until the response arrives, and return the response.

        >>> sim.call("/set_bool", {"data": True})  # doctest: +SKIP

        Args:
            service: full name of the service.
            request: mapping of fields, or a request message.
            timeout: longest simulation time to wait for the response, s.
            type: name of the service type, such as `std_srvs/srv/SetBool`; needed if no graph uses the service.

        Returns:
            The response message.

        Raises:
            MessageError: the request does not match its type.
            TransportError: no response arrives within the timeout.
            UsageError: no graph uses the service and `type` is missing, or the graphs use another type.
        """
        return call_service(self._runner, service, request, timeout, type)

    @acting
    def start_call(self, service: str, request: Any, type: str | None = None) -> ServiceCall:
        """Call a service without waiting for the response, which arrives while ticks run; close the call at the end.

        >>> sim.start_call("/set_bool", {"data": True})  # doctest: +SKIP

        Args:
            service: full name of the service.
            request: mapping of fields, or a request message; None only looks for a server.
            type: name of the service type; needed if no graph uses the service.

        Raises:
            MessageError: the request does not match its type.
            UsageError: no graph uses the service and `type` is missing, or the graphs use another type.
        """
        return ServiceCall(self._runner, service, request, type)

    @acting
    def send_goal(self, action: str, goal: Any, type: str | None = None) -> Goal:
        """Send a goal of an action, which is executed while ticks run; close the goal at the end.

        >>> sim.send_goal("/navigate_to_pose", {}, "nav2_msgs/action/NavigateToPose")  # doctest: +SKIP

        Args:
            action: full name of the action.
            goal: mapping of fields, or a goal message.
            type: name of the action type; needed if no graph uses the action.

        Raises:
            MessageError: the goal does not match its type.
            UsageError: no graph uses the action and `type` is missing, or the graphs use another type.
        """
        return Goal(self._runner, action, goal, type)

    @reading
    def nodes(self) -> list[str]:
        """Return the full names of the ROS nodes of other programs that are known so far, sorted.

        >>> sim.nodes()  # the transport `memory` has no other programs
        []
        """
        transport = self._runner.network.transport(0)
        return sorted({node.name for node in transport.graph().nodes} - {transport.node})
