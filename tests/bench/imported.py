"""What a robot costs that a user brings: an imported base beside the dd100, an arm beside its own physics, a fleet of such bases.

`python -m tests.bench.imported [TURNS]` prints the processor time of a tick of each, over memory, with a reader on every topic.
The sides of a comparison take turns of a second of simulation in one run; a ratio is the median over the turns. Nothing is
asserted.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from graphengine.messages import messages
from graphengine.messages.endpoints import QoS
from graphengine.ros.network import LiveNetwork
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.runtime.session_core import SessionCore
from graphengine.scene import build
from graphengine.scene.loaded_scene import Options
from tests import arm_scene
from tests.trajectories import trajectory

FLEET = 100
DD100 = """
    format: 1
    scene: dd100
    world: worlds/flat_grid.xml
    robots: {dd100: {use: robots/dd100.yaml, position: [0, 0, 0.025]}}
    graphs: {clock: {use: graphs/clock.yaml, at: /World/clock}}
"""
CIRCLE = messages.Twist(messages.Vector3(0.2, 0.0, 0.0), messages.Vector3(0.0, 0.0, 0.8))
TWISTS = "geometry_msgs/msg/Twist"
TRAJECTORIES = "trajectory_msgs/msg/JointTrajectory"
_INERTIA = '<inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/>'
_LINK = f'<link name="{{}}"><inertial><mass value="{{}}"/>{_INERTIA}</inertial>{{}}</link>'
_SHAPE = '<collision><origin rpy="{} 0 0"/><geometry>{}</geometry></collision>'


class Side:
    """A running scene whose topics are all read, and the processor time of a second of its simulation."""

    def __init__(self, session: SessionCore, prepare: Callable[[], None]) -> None:
        self.session, self._prepare = session, prepare
        self.ticks = round(1.0 / session.clock.delta)
        self.turn()  # warm

    def turn(self) -> float:
        """Microseconds a tick, after two ticks in which the commands arrive."""
        self._prepare()
        self.session.step(2)
        start = time.thread_time()
        self.session.step(self.ticks)
        return (time.thread_time() - start) / self.ticks * 1e6


class Physics:
    """The steps of a scene's physics alone, of the state that it has reached."""

    def __init__(self, side: Side) -> None:
        self.world, self.ticks = side.session.services.world, side.ticks

    def turn(self) -> float:
        """Microseconds a tick."""
        steps = self.ticks * self.world.substeps
        start = time.thread_time()
        for _ in range(steps):
            self.world.step()
        return (time.thread_time() - start) / self.ticks * 1e6


def base() -> str:
    """A differential base with two wheels and a ball."""
    box, ball = '<box size="0.4 0.3 0.1"/>', '<sphere radius="0.04"/>'
    wheel = '<cylinder radius="0.08" length="0.03"/>'
    links = [
        _LINK.format("base_link", 10, *[0.2] * 3, _SHAPE.format(0, box)),
        *(_LINK.format(name, 0.5, *[0.001] * 3, _SHAPE.format(1.5708, wheel)) for name in ("left", "right")),
        _LINK.format("ball", 0.2, *[0.0005] * 3, _SHAPE.format(0, ball)),
    ]
    joints = [
        f'<joint name="{name}_wheel_joint" type="continuous"><parent link="base_link"/><child link="{name}"/>'
        f'<origin xyz="0.1 {y} -0.02"/><axis xyz="0 1 0"/><limit effort="20" velocity="30"/></joint>'
        for name, y in (("left", 0.17), ("right", -0.17))
    ]
    under = '<parent link="base_link"/><child link="ball"/><origin xyz="-0.15 0 -0.06"/>'
    fixed = f'<joint name="ball_joint" type="fixed">{under}</joint>'
    return "\n".join(['<robot name="bot">', *links, *joints, fixed, "</robot>\n"])


def imported(folder: Path) -> Path:
    """The scene of a project that `graphrun new` makes from the base."""
    (folder / "bot.urdf").write_text(base(), encoding="utf-8")
    command = [sys.executable, "-m", "graphengine.cli", "new", str(folder / "bot"), "--from", str(folder / "bot.urdf")]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return folder / "bot" / "bot.yaml"


def fleet(scene: Path) -> Path:
    """The same scene with a hundred of its robots."""
    many = f"count: {FLEET}\n    per_row: 10\n    spacing: [1.2, 1.2]\n    position:"
    path = scene.with_name("fleet.yaml")
    path.write_text(scene.read_text(encoding="utf-8").replace("position:", many, 1), encoding="utf-8")
    return path


def arm(folder: Path) -> Path:
    """The scene of the tests' arm of seven drives."""
    for name, text in arm_scene.files().items():
        (folder / name).write_text(textwrap.dedent(text), encoding="utf-8")
    return folder / "scene.yaml"


@contextmanager
def running(scene: Path, *, drive: bool = True) -> Iterator[Side]:
    """The scene over memory; bases drive in circles, arms follow a trajectory, unless `drive` is false."""
    transport = MemoryTransport()
    assembly = build.load(scene)
    moved = {claim.topic: claim.message_type for claim in assembly.claims if claim.direction == "subscribe"}
    if drive and TWISTS in moved.values():
        assembly = build.load(scene, Options({"SubscribeTwist.timeout": 0.0}))
    with build.start(assembly, LiveNetwork(lambda _: transport, 0, print)) as session:
        for claim in assembly.claims:
            if claim.direction == "publish":
                transport.reader(claim.topic, claim.message_type, QoS(), lambda _: None)

        def prepare() -> None:
            for topic, kind in moved.items() if drive else ():
                if kind == TWISTS:
                    transport.inject(topic, CIRCLE)
                elif kind == TRAJECTORIES:
                    whole = arm_scene.fifty()
                    transport.inject(topic, trajectory(whole.joint_names, *whole.points))

        yield Side(session, prepare)


def compare(one: Side | Physics, other: Side | Physics, turns: int) -> tuple[float, float, float]:
    """Microseconds a tick of both at their least, and the median of one over the other, turn by turn."""
    times = [(one.turn(), other.turn()) for _ in range(turns)]
    return min(a for a, _ in times), min(b for _, b in times), statistics.median(a / b for a, b in times)


def main() -> None:
    """Print a line for each comparison."""
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else 15
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder = Path(name)
        bot = imported(folder)
        (folder / "dd100.yaml").write_text(textwrap.dedent(DD100), encoding="utf-8")
        dd100, alone = (stack.enter_context(running(path)) for path in (folder / "dd100.yaml", bot))
        theirs, ours, ratio = compare(alone, dd100, turns)
        print(
            f"imported base without lidar {theirs:.0f} us a tick, dd100 with its lidar {ours:.0f} us: x{ratio:.2f} (bar 1.5)"
        )
        many = stack.enter_context(running(fleet(bot)))
        theirs, ours, ratio = compare(many, alone, max(3, turns // 3))
        print(f"{FLEET} imported bases {theirs / 1e3:.2f} ms a tick: x{ratio / FLEET:.2f} of one alone, each")
        for what, drive in (("holds its pose", False), ("follows a trajectory", True)):
            moving = stack.enter_context(running(arm(folder), drive=drive))
            theirs, ours, ratio = compare(moving, Physics(moving), turns)
            print(
                f"arm of 7 drives that {what} {theirs:.0f} us a tick: x{ratio:.2f} of its physics steps, {ours:.0f} us"
            )


if __name__ == "__main__":
    main()
