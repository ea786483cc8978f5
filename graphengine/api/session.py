"""The class `Session`: a running scene whose values programs read and change between two ticks."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from graphengine.api.guards import acting, reading
from graphengine.api.mujoco_objects import MujocoObjects
from graphengine.api.pictures import look, simulated, write_png
from graphengine.api.robots import Robot, Robots
from graphengine.api.runner import AfterTick, Runner
from graphengine.api.topics import M, MessageType, Publication, Subscription, call_service, open_subscription
from graphengine.api.values import plain, read_only
from graphengine.api.viewing import open_page
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.errors import UsageError
from graphengine.format.wording import did_you_mean, listing
from graphengine.runtime.addresses import NodePort, find_port_at, find_ports

if TYPE_CHECKING:
    from graphengine.runtime.reloading import Reloaded
    from graphengine.runtime.run_control import SessionState
    from graphengine.runtime.session_core import SavedSession as InnerCheckpoint
    from graphengine.runtime.session_core import SessionCore as InnerSession
    from graphengine.runtime.ticker import ResetScope


class Checkpoint:
    """The complete state of a session, made by `Session.checkpoint` for `Session.restore`."""

    def __init__(self, inner: InnerCheckpoint, publications: Sequence[tuple[AfterTick, Any]]) -> None:
        self._inner = inner
        self._publications = publications

    def __repr__(self) -> str:
        return f"<Checkpoint {self._inner.name}>"


class Session:
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
        self._runner = runner
        self._graphs: object = None
        self._ports: dict[str, NodePort] = {}
        """Cache of `value`: ports of `_graphs` by the address that the caller gave."""

    # Time

    @property
    @reading
    def time(self) -> float:
        """Simulation time, s; 0 at the start and after a reset of the time."""
        return self._runner.session.time

    @property
    @reading
    def tick(self) -> int:
        """Number of ticks since the start or since the last reset of the time."""
        return self._runner.session.clock.frame

    @property
    @reading
    def state(self) -> SessionState:
        """`stopped` (at time 0), `playing` (during `run`), `paused` (after `run` or `step`) or `failed` (after an error)."""
        return self._runner.session.state

    @acting
    def step(self, ticks: int = 1) -> None:
        """Run a number of ticks, as fast as possible.

        >>> sim.step(3)

        Raises:
            NodeError: a node raised an exception; joint commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        count = operator.index(ticks)
        if count < 0:
            raise UsageError(f"ticks: expected 0 or more, got {count}")
        self._runner.step(count)

    @acting
    def run(
        self,
        seconds: float | None = None,
        rate: float | None = None,
        until: Callable[[Session], bool] | None = None,
    ) -> bool:
        """Run for a duration in simulation time, or until a condition holds.

        Ctrl-C ends the run between two ticks and raises KeyboardInterrupt; the session stays usable.

        >>> sim.run(1.0)
        True
        >>> sim.run(10.0, until=lambda s: s.time > 1.2)
        True

        Args:
            seconds: duration in simulation time, s; None runs without end.
            rate: seconds of simulation per second of wall time; infinity runs as fast as possible. None runs as fast as
                possible with the transport `memory`, and in real time with other transports.
            until: condition, called before the first tick and after each tick; if it returns True, the run ends.

        Returns:
            With `until`, whether the condition held; without `until`, whether the whole duration passed without `interrupt`.

        Raises:
            NodeError: a node raised an exception; joint commands were set to zero.
            PhysicsError: the simulation diverged.
        """
        held = False

        def goes_on(_: InnerSession) -> bool:
            nonlocal held
            held = until is not None and until(self)
            return not held

        passed = self._runner.run(seconds, rate, goes_on, first=goes_on)
        return held if until is not None else passed

    def interrupt(self) -> None:
        """End the current `run` after the present tick; without a current `run`, end the next `run` before its first tick.

        Any thread may call this method.
        """
        self._runner.session.interrupt()

    @reading
    def reset(self, *scopes: ResetScope, seed: int | None = None) -> None:
        """Reset the whole session or a part of it. Inputs changed by `set` keep their values.

        >>> sim.reset("state")

        Args:
            scopes: parts to reset: `time` resets the clock and the graphs, `state` resets bodies and joints, `spawned`
                removes spawned robots. Without scopes, everything is reset.
            seed: new seed of all random generators, used if the time is reset; None keeps the seed.

        Raises:
            UsageError: a spawned robot cannot be removed because a graph outside this robot reads from this robot.
        """
        self._runner.command("reset", scope=list(scopes) or "all", seed=seed)

    @acting
    def checkpoint(self) -> Checkpoint:
        """Save the complete state; `restore` can return to it any number of times. A recording stores the call.

        The call waits until all images that are being rendered are finished.

        >>> sim.checkpoint()
        <Checkpoint checkpoint_1>

        Raises:
            NodeError: the state of a node cannot be copied.
        """
        inner = self._runner.session.checkpoint()
        return Checkpoint(inner, [(publication, publication.save()) for publication in self._runner.publications])

    @reading
    def restore(self, checkpoint: Checkpoint) -> None:
        """Return to a checkpoint of this session. A recording stores the call.

        With the transport `memory`, repeating the calls that followed the checkpoint sends the same bytes again. `restore` does
        not withdraw messages that were already sent, and does not remove messages that a `Subscription` keeps. It does not set
        back sequence numbers of DDS or times in a recording.

        >>> mark = sim.checkpoint()
        >>> sim.run(1.0)
        True
        >>> sim.restore(mark)
        >>> sim.time
        0.0

        Args:
            checkpoint: checkpoint of this session.

        Raises:
            GraphError: a removed robot or a node cannot be restored.
            UsageError: the checkpoint belongs to another session.
        """
        self._runner.session.restore(checkpoint._inner)
        for publication, state in checkpoint._publications:
            publication.restore(state)

    @acting
    def reload(self) -> Reloaded:
        """Read the files of the scene again and run the changed scene. A recording stores the call, with the changed files.

        Changed graphs are replaced, and the world continues. A node whose name, type and ports are unchanged keeps its
        state. A wired input keeps its value if its wire is unchanged; an unwired input keeps its value if the file gives it the
        same value as before. Unchanged topics keep their endpoints. A change of the world or of a robot restarts the session at
        time 0, without spawned robots. `restore` with a checkpoint from before the reload returns to the scene as it was before
        the reload. Python modules with node types are not imported again.

        >>> print(sim.reload())
        no file changed: graphs and world are unchanged

        Raises:
            CheckError: the files have errors; nothing has changed.
            GraphError: the changed scene cannot start; nothing has changed.
        """
        return self._runner.act(lambda session: session.reload())

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

    # The world

    @property
    @reading
    def robots(self) -> Mapping[str, Robot]:
        """All robots by name, including spawned robots.

        >>> sim.robots["dd100"].namespace
        'dd100_0000'
        """
        prims = self._runner.session.services.stage.prims("robot")
        return Robots((prim.entity_name, Robot(self._runner, prim.entity_name)) for prim in prims)

    @property
    def mujoco(self) -> MujocoObjects:
        """MuJoCo's own model and state. Writes to them are not recorded; `MujocoObjects` says when they are overwritten.

        >>> round(float(sim.mujoco.model.opt.timestep), 6)  # s; four substeps at 60 Hz
        0.004167

        Raises:
            UsageError: the session runs a graph without a scene (when `model` or `data` is read).
        """
        return MujocoObjects(self._runner)

    @acting
    def move(
        self,
        entity: str,
        position: Sequence[float] | None = None,
        orientation: Quaternion | None = None,
        linear: Vector3 | None = None,
        angular: Vector3 | None = None,
        *,
        force: bool = False,
        odometry: Literal["continues", "jumps"] = "continues",
    ) -> None:
        """Move a robot or object to a pose; joint states do not change. A pose at which it overlaps others is refused.

        >>> sim.move("dd100", position=(1.0, 2.0))

        Args:
            entity: name of the robot or the object.
            position: (x, y, z), or (x, y) to keep the height, in the world frame, m; None keeps the position.
            orientation: quaternion (x, y, z, w) in the world frame; None keeps the orientation.
            linear: linear velocity after the move, in the world frame, m/s; None means zero.
            angular: angular velocity after the move, in the world frame, rad/s; None means zero.
            force: whether to place the entity even if it overlaps others; this logs a warning, and physics pushes them apart.
            odometry: whether ground-truth odometry (`IsaacComputeOdometry`) continues, as REP 105 demands, or jumps with the
                robot. Wheel odometry never jumps, because the wheels do not roll.

        Raises:
            BlockedPoseError: the entity would overlap others by 5 mm or more; planes below the entity, such as the floor, do
                not count.
            UnknownEntityError: no robot or object has the name.
            UsageError: the robot or object cannot be moved.
        """
        turned = {"quaternion_xyzw": plain(orientation)} if orientation is not None else None
        where = {"position": position, "orientation": turned, "linear": linear, "angular": angular}
        self._runner.command("move", entity=entity, force=force, odometry=odometry, **plain(where))

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
        """Apply a force or an impulse to a robot or object.

        >>> sim.push("dd100", force=(0, 80, 0), duration=0.5)

        Args:
            entity: name of the robot or the object.
            force: force in the world frame, N.
            duration: simulation time for which the force or impulse acts, s; required for a force. For an impulse, None is one
                tick.
            impulse: impulse in the world frame, N s, spread over `duration`; an alternative to `force`.
            at: point of application in the world frame, m; None is the centre of mass.

        Raises:
            UnknownEntityError: no robot or object has the name.
            UsageError: the robot or object cannot move; `force` and `impulse` are both given or both missing; or `duration` is
                missing for a force.
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
        force: bool = False,
    ) -> Robot:
        """Add a robot to the scene and return it. A pose at which it overlaps others is refused.

        >>> sim.spawn("second", "robots/dd100.yaml", position=(0, 2, 0.03), namespace="second").namespace
        'second'

        Args:
            name: name of the robot, unique in the scene.
            use: robot file or robot description (such as URDF). A path is first looked up in the working directory;
                if it is not found there, it is looked up like the value of `use` in a scene file.
            position: position of the robot's base link in the world frame, m.
            orientation: orientation of the robot's base link in the world frame, quaternion (x, y, z, w).
            namespace: namespace of the robot's topics; None takes the namespace in the robot file.
            at: path of the robot's prim; None is `/NAME`.
            robot_state: whether to publish the topics of robot_state_publisher for the robot.
            force: whether to add the robot even if it overlaps others; this logs a warning, and physics pushes them apart.

        Raises:
            BlockedPoseError: the robot would overlap others by 5 mm or more; planes below the robot, such as the floor, do not
                count.
            CheckError: the robot or one of its graphs has errors; nothing has changed.
            UsageError: the session runs a graph without a scene, or an argument is invalid.
        """
        given = {
            "use": os.path.abspath(use) if os.path.isfile(use) else str(use),
            "position": position,
            "orientation": {"quaternion_xyzw": orientation},
            "namespace": namespace,
            "at": at,
            "robot_state": robot_state,
        }
        use_given = {key: plain(it) for key, it in given.items() if it is not None}
        self._runner.command("spawn", name=name, use=use_given, force=force)
        return Robot(self._runner, name)

    @acting
    def remove(self, name: str) -> None:
        """Remove a robot, its graphs and its topics.

        >>> sim.remove("dd100")

        Raises:
            UnknownEntityError: no robot has the name.
            UsageError: a graph outside the robot reads from this robot.
        """
        self._runner.command("delete", name=name)

    @acting
    def impulse(self, node: str) -> None:
        """Trigger an OnImpulseEvent node in the next tick.

        >>> sim.impulse("Node")  # doctest: +SKIP

        Args:
            node: prim path of the node, or a unique suffix of it.

        Raises:
            UsageError: no node or several nodes match the path.
        """
        self._runner.command("impulse", node=node)

    @acting
    def press(self, *keys: str) -> None:
        """Press keys of the simulated keyboard, from the next tick until `release`. Keys have the names that OmniGraph uses.

        >>> sim.press("W", "LeftShift")

        Raises:
            UsageError: a key has an unknown name.
        """
        self._runner.command("press", keys=list(keys))

    @acting
    def release(self, *keys: str) -> None:
        """Release keys of the simulated keyboard; a key that was pressed since the last tick stays down for one tick.

        >>> sim.release("W", "LeftShift")

        Raises:
            UsageError: a key has an unknown name.
        """
        self._runner.command("release", keys=list(keys))

    @reading
    def picture(
        self, view: str = "perspective", path: str | PathLike[str] | None = None, size: tuple[int, int] | None = None
    ) -> NDArray[np.uint8]:
        """Return an image of the world in its current state.

        >>> sim.picture("top", size=(320, 180)).shape  # doctest: +SKIP
        (180, 320, 3)

        Args:
            view: `perspective` (all robots), `follow` (behind the first robot), `top`, the name of a camera in the world's
                MJCF, or the name or path of a camera prim.
            path: PNG file to write; None writes no file.
            size: width and height, pixels; None is the camera's own size, or (1280, 720) for a view.

        Returns:
            RGB pixels of shape (height, width, 3).

        Raises:
            OSError: the file cannot be written.
            RenderError: OpenGL is missing or failed.
            UsageError: no view or camera has the name `view`, several camera prims have this name, or the session has no scene.
        """
        pixels = look(simulated(self._runner.session.services.world), view, size).rgb
        if path is not None:
            write_png(pixels, Path(path))
        return pixels

    @acting
    def video(
        self,
        path: str | PathLike[str],
        seconds: float,
        view: str = "follow",
        size: tuple[int, int] | None = None,
        fps: int = 20,
    ) -> bool:
        """Run for a duration in simulation time, as `run` does, and write a video of it.

        >>> sim.video("drive.webp", 10.0, view="follow")  # doctest: +SKIP
        True

        Args:
            path: file to write: `.webp`, `.gif`, or `.mp4`, which needs the program ffmpeg.
            seconds: duration in simulation time, s.
            view: as for `picture`; `follow` moves with the first robot, and `perspective` keeps all robots in the image.
            size: width and height, pixels; None is the camera's own size, or (640, 360) for a view.
            fps: images per second of simulation time.

        Returns:
            Whether the whole duration passed without `interrupt`. The video ends where the run ended.

        Raises:
            NodeError: a node raised an exception; joint commands were set to zero. No file is written.
            OSError: the file cannot be written.
            PhysicsError: the simulation diverged. No file is written.
            RenderError: OpenGL is missing or failed, or ffmpeg failed.
            UsageError: an argument is invalid, the video would be too large, no view or camera has the name `view`, several
                camera prims have this name, the session has no scene, or ffmpeg is missing.
        """
        from graphengine.api.video import Video

        session = self._runner.session
        world = simulated(session.services.world)
        with closing(Video(world, Path(path), view, seconds, session.clock.delta, size, fps)) as video:
            video.after_ticks(0)
            passed = self._runner.run(seconds, None, lambda _: video.after_ticks() or True)
            video.write()
        return passed

    @acting
    def view(self, host: str = "127.0.0.1", port: int = 0, *, read_only: bool = False) -> str:
        """Serve a web page that shows the world in 3D and the graphs with live values, and that controls the session.

        The address contains the access token, so anyone who has the address can use the page. Each tick updates the page;
        between calls of `run` and `step` the page does not change.

        >>> sim.view()  # doctest: +SKIP
        'http://127.0.0.1:40123/#token=…'

        Args:
            host: address to listen on; an address other than 127.0.0.1 lets other machines connect without encryption.
            port: TCP port; 0 chooses a free one.
            read_only: whether viewers can only watch the session, not control it.

        Returns:
            The address of the page. Further calls return the same address while the process that serves the page runs.

        Raises:
            UsageError: the extra `view` is not installed, or the port is in use.
        """
        return open_page(self._runner, host, port, read_only=read_only).wait()

    # From other threads

    def submit(self, command: str, arguments: Mapping[str, Any] | None = None) -> Future[Any]:
        """Queue a command of `graphrun ctl` for execution before the next tick; any thread may call this method.

        >>> done = sim.submit("push", {"entity": "dd100", "force": [0, 80, 0], "duration": 0.5})
        >>> sim.step()
        >>> done.result(timeout=0)

        Args:
            command: name of the command. `pause` and `stop` suspend a `run`, `play` and `step` resume it, and `quit` ends it. The
                other commands are `reset`, `rate`, `spawn`, `delete`, `move`, `push`, `command`, `set`, `impulse`, `press`,
                `release`, `reload` and `state`.
            arguments: arguments of the command, as JSON values.

        Returns:
            A future, which the session's thread completes with the result or with an exception: the exception of the
            command, UsageError for invalid arguments, or StateError if the session is closed before the
            command is executed.

        Raises:
            UsageError: an argument cannot be converted to JSON.
        """
        return self._runner.queue.submit(command, plain(arguments))

    def close(self) -> None:
        """End the session: run the graphs' closing events, then close the recording and the network.

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
