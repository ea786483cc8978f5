"""The part of a session that shows and changes the world: robots, pushes, moves, keys, pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from graphengine.api.bodies import Body
from graphengine.api.guards import acting, reading
from graphengine.api.mujoco_objects import MujocoObjects
from graphengine.api.pictures import look, simulated, write_png
from graphengine.api.robots import Robot, Robots
from graphengine.api.session_control import SessionControl
from graphengine.api.values import plain
from graphengine.api.viewing import open_page
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.runtime.command import find_robot
from graphengine.runtime.why.explanation import Explanation, explain


class SessionWorld(SessionControl):
    """Shows the world of a session and changes it: its robots, its objects and its keyboard."""

    @property
    @reading
    def robots(self) -> Mapping[str, Robot]:
        """All robots by name, including spawned robots.

        >>> sim.robots["dd100"].namespace
        'dd100_0000'
        """
        return Robots((name, Robot(self._runner, name)) for name in self._runner.session.services.stage.robots())

    @reading
    def body(self, name: str) -> Body:
        """Return a body, which has the pose, velocity and contacts of a robot, an object or another prim.

        >>> round(sim.body("/dd100/Geometry/base_link/chassis_link/sim_lidar").pose.position[2], 2)
        0.16

        Args:
            name: name of a robot or object, or the path of a prim.

        Raises:
            UnknownEntityError: no robot or object has the name, or no prim has the path.
        """
        body = Body(self._runner, name)
        body.find()
        return body

    @property
    def mujoco(self) -> MujocoObjects:
        """MuJoCo's own model and state. Writes to them are not recorded; `MujocoObjects` says when they are overwritten.

        >>> round(float(sim.mujoco.model.opt.timestep), 6)  # s; four substeps at 60 Hz
        0.004167

        Raises:
            UsageError: the session runs a graph without a scene (when `model` or `data` is read).
        """
        return MujocoObjects(self._runner)

    @reading
    def why(self, robot: str) -> Explanation:
        """Explain why a robot stands still; `graphrun ctl why` and the web page show the same text.

        >>> sim.run(0.1)
        True
        >>> sim.why("dd100").sentence
        'nobody publishes on /dd100_0000/cmd_vel, from which dd100/cmd_vel/SubscribeTwist takes its commands'

        Args:
            robot: name of the robot.

        Raises:
            UnknownEntityError: no robot has the name.
        """
        return explain(self._runner.session, find_robot(self._runner.session, robot), paused_counts=False)

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
    def fault(
        self,
        *,
        sensor: str | None = None,
        topic: str | None = None,
        silent: bool = False,
        dropout: float | None = None,
        delay: float | None = None,
        duration: float | None = None,
    ) -> None:
        """Let a sensor or a topic fail from the next tick on. A recording stores the call.

        The fault replaces an earlier fault of the sensor or topic. It ends after `duration`, by `mend`, or when the time is
        reset. Delayed data that has not arrived by then is lost. A fault of a topic acts where graphs publish the topic; if no
        graph does, it acts where graphs receive it.

        >>> sim.fault(topic="/dd100_0000/odom", delay=0.3, duration=2.0)
        >>> sim.fault(sensor="dd100/sim_lidar", dropout=0.2)
        >>> sim.mend()

        Args:
            sensor: name of the sensor, ROBOT/SENSOR, or path of its prim.
            topic: full name of the topic; give either a sensor or a topic.
            silent: whether all samples or messages are lost.
            dropout: probability with which each sample or message is lost; the session's seed determines which ones are.
            delay: time by which samples or messages arrive later, s, rounded to whole ticks; their stamps do not change.
            duration: simulation time after which the fault ends, s; None: it does not end by itself.

        Raises:
            UnknownEntityError: there is no such sensor or topic.
            UsageError: `silent`, `dropout` and `delay` are all missing, or `silent` is given together with others.
        """
        how = {"silent": silent, "dropout": dropout, "delay": delay, "duration": duration}
        self._runner.command("fault", sensor=sensor, topic=topic, **how)

    @acting
    def mend(self, *, sensor: str | None = None, topic: str | None = None) -> None:
        """End the fault of a sensor or a topic; without arguments, end all faults. A recording stores the call.

        >>> sim.fault(topic="/dd100_0000/odom", silent=True)
        >>> sim.mend(topic="/dd100_0000/odom")
        """
        self._runner.command("mend", sensor=sensor, topic=topic)

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
