"""The public session: a scene that runs, between whose ticks everything can be read and changed."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from graphengine.api.pictures import look, simulated, write_png
from graphengine.api.robots import Robot, Robots
from graphengine.api.runner import Runner, acting, reading
from graphengine.api.topics import M, MessageType, Publication, Subscription, call_service, open_subscription
from graphengine.api.values import Values, plain, read_only
from graphengine.devices.sensor import Quaternion, Vector3
from graphengine.format.errors import UsageError
from graphengine.format.wording import did_you_mean, listing

if TYPE_CHECKING:
    from graphengine.runtime.session import Checkpoint as InnerCheckpoint
    from graphengine.runtime.session import Session as InnerSession
    from graphengine.runtime.session import SessionState
    from graphengine.runtime.ticker import ResetScope


class Checkpoint:
    """The whole state of a session. `Session.checkpoint` makes it, and `Session.restore` goes back to it."""

    def __init__(self, inner: InnerCheckpoint, publications: Sequence[tuple[Publication, Any]]) -> None:
        self._inner = inner
        self._publications = publications

    def __repr__(self) -> str:
        return f"<Checkpoint {self._inner.name}>"


class Session:
    """A scene that runs: one world, one network, one state for each node. `Scene.session` makes it.

    Times are s of simulation, lengths m, angles rad, forces N; poses and velocities are in the world frame, quaternions
    (x, y, z, w). Changes take effect in the next tick. Arrays cannot be written to; copy one to keep it.

    Use a session from one thread at a time: only `submit` and `interrupt` may be called from any thread, a concurrent call of
    anything else raises StateError. After a NodeError or PhysicsError the state is `failed`: values can be read, everything else
    raises StateError until `reset`.

    >>> with ge.load("dd100_flat").session() as sim:
    ...     drive = sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
    ...     sim.run(2.0)
    ...     sim.robots["dd100"].pose.position[0] > 0.5
    True
    True
    """

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._values = Values(runner)

    # Time

    @property
    @reading
    def time(self) -> float:
        """Time since play, s of simulation."""
        return self._runner.session.time

    @property
    @reading
    def tick(self) -> int:
        """Number of ticks since play."""
        return self._runner.session.clock.frame

    @property
    @reading
    def state(self) -> SessionState:
        """`stopped` at time 0, `playing` within `run`, `paused` after it, or `failed`."""
        return self._runner.session.state

    @acting
    def step(self, ticks: int = 1) -> None:
        """Run some ticks, as fast as possible.

        >>> sim.step(3)

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        count = operator.index(ticks)
        if count < 0:
            raise UsageError(f"ticks: expected a number that is not negative, got {count}")
        self._runner.step(count)

    @acting
    def run(
        self,
        seconds: float | None = None,
        rate: float | None = None,
        until: Callable[[Session], bool] | None = None,
    ) -> bool:
        """Run for some time of simulation, or until something holds.

        Ctrl-C ends it between two ticks and raises KeyboardInterrupt; the session can be used on.

        >>> sim.run(1.0)
        True
        >>> sim.run(10.0, until=lambda s: s.time > 1.2)
        True

        Args:
            seconds: s of simulation; None for ever.
            rate: s of simulation in a second of wall time; infinity for as fast as possible. None is that over memory, else
                real time.
            until: called before the first tick and after each; True ends the run.

        Returns:
            Whether `until` held; without it, whether the whole time passed and `interrupt` did not end it.

        Raises:
            NodeError: a node raised; commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        held = until is not None and until(self)

        def on_tick(_: InnerSession) -> bool:
            nonlocal held
            held = until is not None and until(self)
            return not held

        passed = not held and self._runner.run(seconds, rate, on_tick)
        return held if until is not None else passed

    def interrupt(self) -> None:
        """End `run` after the tick, or the next `run` before its first; any thread may call it."""
        self._runner.session.interrupt()

    @reading
    def reset(self, *scopes: ResetScope) -> None:
        """Begin anew, wholly or in part. Inputs that were set keep their values.

        >>> sim.reset("state")

        Args:
            scopes: `time`: clock and graphs; `state`: bodies and joints; `spawned`: robots that came. All if none is given.

        Raises:
            UsageError: a graph that is not its own reads something of a robot that is to go.
        """
        self._runner.command("reset", scope=list(scopes) or "all")

    @acting
    def checkpoint(self) -> Checkpoint:
        """Keep the whole state, to go back to it as often as wanted, as long as the checkpoint is held. Recorded.

        A picture that is being drawn is waited for.

        >>> sim.checkpoint()
        <Checkpoint checkpoint_1>

        Raises:
            NodeError: a node holds what cannot be copied.
        """
        inner = self._runner.session.checkpoint()
        return Checkpoint(inner, [(publication, publication.save()) for publication in self._runner.publications])

    @reading
    def restore(self, checkpoint: Checkpoint) -> None:
        """Go back to a checkpoint of this session: over memory the same bytes follow from the same calls. Recorded.

        Messages that have left the process are not taken back, nor are those that subscriptions here have kept; writer
        numbers of dds and the times of a recording go on.

        >>> mark = sim.checkpoint()
        >>> sim.run(1.0)
        True
        >>> sim.restore(mark)
        >>> sim.time
        0.0

        Args:
            checkpoint: what `checkpoint` returned.

        Raises:
            GraphError: a robot that has gone, or a node, cannot be what it was.
            UsageError: the checkpoint is another session's.
        """
        self._runner.session.restore(checkpoint._inner)
        for publication, state in checkpoint._publications:
            publication.restore(state)

    # Values of nodes

    @reading
    def value(self, address: str) -> Any:
        """What a port holds, in the port's own form; an array is a read-only view, which later ticks may leave behind.

        >>> sim.value("dd100/joint_states/ComputeOdom.position")
        (0.0, 0.0, 0.0)

        Args:
            address: `[robot/][graph/][subgraph/…]Node.[inputs:|outputs:|state:]port`, or as much of its end as no other has.
                Without a side an output is meant first, then an input.

        Raises:
            UsageError: no port, or several.
        """
        return self._values.one(address)

    @reading
    def values(self, pattern: str) -> dict[str, Any]:
        """What ports hold, by address.

        >>> sim.values("*/joint_states/ComputeOdom.position")
        {'dd100/joint_states/ComputeOdom.position': (0.0, 0.0, 0.0)}

        Args:
            pattern: an address as in `value`, with globs in its parts.

        Raises:
            UsageError: it matches nothing.
        """
        return self._values.matching(pattern)

    @acting
    def set(self, address: str, value: Any) -> None:
        """Give inputs that no wire feeds another value, which they keep through `reset`. Recorded.

        >>> sim.set("dd100/cmd_vel/DiffController.maxLinearSpeed", 1.0)

        Args:
            address: `[robot/][graph/]Node.port`, globs allowed.
            value: as a graph file would have it; the same for all inputs that the address matches.

        Raises:
            UsageError: no such input, a wired one, or a value that it does not take; nothing has changed.
        """
        self._runner.command("set", address=address, value=plain(value))

    @reading
    def variables(self, graph: str) -> dict[str, Any]:
        """Values of a graph's variables, by name; `subgraph/name` for those of subgraphs.

        >>> sim.variables("dd100/cmd_vel")
        {}

        Args:
            graph: `robot/graph`, or as much of its end as no other has.

        Raises:
            UsageError: no such graph, or several.
        """
        runs = {run.name: run for run in self._runner.session.graphs}
        meant = [name for name in runs if name == graph] or [name for name in runs if name.endswith(f"/{graph}")]
        if len(meant) != 1:
            near = listing(meant, "write one of") if meant else did_you_mean(graph, runs) or listing(runs, "graphs")
            raise UsageError(f"{f'{len(meant)} graphs' if meant else 'no graph'} {graph!r}\n  {near}")
        return {name: read_only(variable.value) for name, variable in runs[meant[0]].variables.items()}

    # Topics and services

    @overload
    def subscribe(self, topic: str, type: type[M], keep: int = 1000) -> Subscription[M]: ...
    @overload
    def subscribe(self, topic: str, type: str | None = None, keep: int = 1000) -> Subscription[Any]: ...
    def subscribe(self, topic: str, type: MessageType = None, keep: int = 1000) -> Subscription[Any]:
        """Read a topic; from here on its messages are built, its sensors cast and its pictures drawn.

        >>> odom = sim.subscribe("/dd100_0000/odom")
        >>> sim.step()
        >>> odom.latest.header.frame_id
        'odom'

        Args:
            topic: full name.
            type: name of the message type where no graph knows the topic, or a class of `graphengine.messages.messages`.
            keep: how many messages are kept; fewer save memory where they are pictures.

        Raises:
            UsageError: no graph knows the topic, or as another type.
        """
        return open_subscription(self, topic, type, keep)

    @acting
    def publish(self, topic: str, message: Any, every: float | None = None, type: MessageType = None) -> Publication:
        """Send a message, which arrives as one of another program would, over memory in the next tick. Recorded as such.

        >>> drive = sim.publish("/dd100_0000/cmd_vel", {"linear": {"x": 0.5}}, every=0.1)
        >>> sim.run(1.0)
        True
        >>> drive.close()

        Args:
            topic: full name.
            message: a mapping of fields, or a message of `graphengine.messages.messages`.
            every: time after which it is sent again, s of simulation, until the publication is closed; None sends it once.
            type: name of the message type, where no graph knows the topic.

        Raises:
            MessageError: the message is not what its type says.
            UsageError: no graph knows the topic, or as another type.
        """
        return Publication(self._runner, topic, message, every, type)

    @acting
    def call(self, service: str, request: Any, timeout: float = 5.0, type: str | None = None) -> Any:
        """Call a service and run ticks until it answers.

        >>> sim.call("/set_bool", {"data": True})  # doctest: +SKIP

        Args:
            service: full name.
            request: a mapping of fields, or a request message.
            timeout: how long to wait for the answer, s of simulation.
            type: name of the service type, as in `std_srvs/srv/SetBool`, where no graph knows the service.

        Returns:
            The response message.

        Raises:
            TransportError: no answer came in time.
            UsageError: no graph knows the service.
        """
        return call_service(self._runner, service, request, timeout, type)

    # The world

    @property
    @reading
    def robots(self) -> Mapping[str, Robot]:
        """Robots by name, those that were spawned among them.

        >>> sim.robots["dd100"].namespace
        'dd100_0000'
        """
        prims = self._runner.session.services.stage.prims("robot")
        return Robots((prim.entity_name, Robot(self._runner, prim.entity_name)) for prim in prims)

    @acting
    def move(
        self,
        entity: str,
        position: Sequence[float] | None = None,
        orientation: Quaternion | None = None,
        linear: Vector3 | None = None,
        angular: Vector3 | None = None,
    ) -> None:
        """Put a robot or an object of the world elsewhere; its joints go on as they are. Overlaps are warned of.

        >>> sim.move("dd100", position=(1.0, 2.0))

        Args:
            entity: name of the robot or the object.
            position: in the world frame, m; of two numbers, the height stays. None for the present one.
            orientation: quaternion (x, y, z, w) in the world frame; None for the present one.
            linear: velocity in the world frame, m/s; at rest when None.
            angular: velocity in the world frame, rad/s; at rest when None.

        Raises:
            UnknownEntityError: there is none of that name.
            UsageError: it cannot be moved.
        """
        turned = {"quaternion_xyzw": plain(orientation)} if orientation is not None else None
        where = {"position": position, "orientation": turned, "linear": linear, "angular": angular}
        self._runner.command("move", entity=entity, **plain(where))

    @acting
    def push(
        self,
        entity: str,
        force: Vector3 | None = None,
        duration: float | None = None,
        *,
        impulse: Vector3 | None = None,
        at: Vector3 | None = None,
    ) -> None:
        """Let a force or an impulse act on a robot or an object of the world.

        >>> sim.push("dd100", force=(0, 80, 0), duration=0.5)

        Args:
            entity: name of the robot or the object.
            force: in the world frame, N.
            duration: how long, s of simulation; one tick for an impulse without it.
            impulse: in place of a force, N s, spread over the duration.
            at: where it acts, in the world frame, m; the centre of mass when None.

        Raises:
            UnknownEntityError: there is none of that name.
            UsageError: nothing can move it, or neither or both of force and impulse are given.
        """
        how = {"force": force, "impulse": impulse, "duration": duration, "at": at}
        self._runner.command("push", entity=entity, **plain(how))

    @acting
    def spawn(
        self,
        name: str,
        use: str | PathLike[str],
        position: Vector3 = (0.0, 0.0, 0.0),
        orientation: Quaternion = (0.0, 0.0, 0.0, 1.0),
        *,
        namespace: str | None = None,
        at: str | None = None,
        robot_state: bool = False,
    ) -> Robot:
        """Put a robot into the scene. Overlaps are warned of.

        >>> sim.spawn("second", "robots/dd100.yaml", position=(0, 2, 0.03), namespace="second").namespace
        'second'

        Args:
            name: of the robot in the scene, which no other has.
            use: robot file, or a description; a file of the working directory, else as the scene would write it.
            position: of its base link in the world frame, m.
            orientation: quaternion (x, y, z, w) in the world frame.
            namespace: of its topics, in place of the robot file's.
            at: path of its prim, `/NAME` when None.
            robot_state: publish what robot_state_publisher would.

        Raises:
            CheckError: the robot, or one of its graphs, has errors; nothing has changed.
            UsageError: the session has no scene.
        """
        given = {
            "use": os.path.abspath(use) if os.path.isfile(use) else str(use),
            "position": position,
            "orientation": {"quaternion_xyzw": orientation},
            "namespace": namespace,
            "at": at,
            "robot_state": robot_state,
        }
        self._runner.command("spawn", name=name, use={key: plain(it) for key, it in given.items() if it is not None})
        return Robot(self._runner, name)

    @acting
    def remove(self, name: str) -> None:
        """Remove a robot, its graphs and its topics.

        >>> sim.remove("dd100")

        Raises:
            UnknownEntityError: there is no such robot.
            UsageError: a graph that is not its own reads something of it.
        """
        self._runner.command("delete", name=name)

    @acting
    def impulse(self, node: str) -> None:
        """Let an OnImpulseEvent node fire in the next tick.

        >>> sim.impulse("Node")  # doctest: +SKIP

        Args:
            node: its prim path, or as much of the end as no other has.

        Raises:
            UsageError: there is no such node, or there are several.
        """
        self._runner.command("impulse", node=node)

    @acting
    def press(self, *keys: str) -> None:
        """Hold keys down from the next tick on, by OmniGraph's names.

        >>> sim.press("W", "LeftShift")

        Raises:
            UsageError: there is no such key.
        """
        self._runner.command("press", keys=list(keys))

    @acting
    def release(self, *keys: str) -> None:
        """Let go of keys; one that was pressed since the last tick is down for one tick.

        >>> sim.release("W", "LeftShift")

        Raises:
            UsageError: there is no such key.
        """
        self._runner.command("release", keys=list(keys))

    @reading
    def picture(
        self, view: str = "perspective", path: str | PathLike[str] | None = None, size: tuple[int, int] | None = None
    ) -> NDArray[np.uint8]:
        """Draw the world as it is now.

        >>> sim.picture("top", size=(320, 180)).shape  # doctest: +SKIP
        (180, 320, 3)

        Args:
            view: `top`, `perspective`, a camera of the world's MJCF, or name or path of a camera's prim.
            path: the PNG to be written; None writes none.
            size: width and height, pixels; (1280, 720), or the camera's own, when None.

        Returns:
            RGB, of shape (height, width, 3).

        Raises:
            OSError: the file cannot be written.
            RenderError: there is no OpenGL, or it refused.
            UsageError: there is no such view or camera.
        """
        pixels = look(simulated(self._runner.session.services.world), view, size).rgb
        if path is not None:
            write_png(pixels, Path(path))
        return pixels

    # From other threads

    def submit(self, command: str, arguments: Mapping[str, Any] | None = None) -> Future[Any]:
        """Queue one of the commands that `graphrun ctl` has, to be carried out before the next tick; any thread may call it.

        >>> done = sim.submit("push", {"entity": "dd100", "force": [0, 80, 0], "duration": 0.5})
        >>> sim.step()
        >>> done.result(timeout=0)

        Args:
            command: `pause` and `stop`, which hold a `run`; `play` and `step`, which let it go on; `quit`, which ends it;
                `reset`, `rate`, `spawn`, `delete`, `move`, `push`, `set`, `impulse`, `press`, `release`, `state`.
            arguments: as JSON has them.

        Returns:
            A future that ends in the session's thread: with the result, what the session raised, UsageError for arguments
            that make no sense, or StateError when the session closes before.

        Raises:
            UsageError: JSON has nothing like the arguments.
        """
        return self._runner.desk.submit(command, plain(arguments))

    def close(self) -> None:
        """End the session: graphs do what they have for the end, and the recording and the network are closed.

        Safe to call twice.

        Raises:
            RecordingError: the recording cannot be written.
        """
        self._runner.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        inner = self._runner.session
        state = "closed" if self._runner.closed else inner.state
        return f"<Session of {self._runner.scene.path.stem}: {state}, t = {inner.time:.3f} s>"
