"""Limits of the rooms api, cli, drawing and view, and of the nodes."""

from __future__ import annotations

import argparse
import io
import logging
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from PIL import Image

import graphengine as ge
from graphengine.api import video
from graphengine.api.recording_page import ReplayLog
from graphengine.api.remote_robot import RemoteState
from graphengine.bringup.navigation.true_poses import TruePoses
from graphengine.cli import import_graph, import_report, log_output, replay
from graphengine.cli.import_urdf import check_source
from graphengine.devices.dry_world import DryWorld
from graphengine.devices.rotation import NOWHERE
from graphengine.devices.stage import Stage
from graphengine.devices.visible import Bodies, VisibleShape
from graphengine.drawing import manual_layout, view_model
from graphengine.drawing.geometry import GAP, LayoutBox
from graphengine.drawing.view_model import make_graph_view
from graphengine.experiments.scenario import read_scenario
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import BadValueError, UsageError
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import EndpointClaim, Network, QoS
from graphengine.messages.interfaces import MessageTypeError
from graphengine.node.context.session_services import Services
from graphengine.nodes.data.sequences import checked_length
from graphengine.nodes.data.strings import check_text_length
from graphengine.nodes.ros2 import joint_trajectory, transform_listener
from graphengine.nodes.ros2.fields import Layout
from graphengine.nodes.ros2.gripper_command import ROS2GripperCommand
from graphengine.nodes.ros2.image_compression import compressed
from graphengine.nodes.ros2.joint_trajectory import TrajectoryError
from graphengine.nodes.ros2.robot_action import RobotActionNode
from graphengine.nodes.wheeled_robots.quintic import QuinticPathPlanner
from graphengine.runtime.command_queue import CommandQueue
from graphengine.testing import session
from graphengine.view import live_findings
from graphengine.view.html.payload import Payload
from graphengine.view.html.scene_data import SceneData
from graphengine.view.html.trace import SampledStage, SceneTrace
from graphengine.view.live_topics import LiveTopics
from graphengine.view.page_server import PageServer
from graphengine.view.scene import shape_surfaces
from graphengine.view.viewers import Viewers
from tests.limits.table import accepts, limit

# api, cli and drawing


@limit("bringup.navigation.true_poses.MAX_SAMPLES", at=4)
def _(samples: int) -> bool:
    poses = TruePoses.__new__(TruePoses)
    poses._times, poses._poses, poses._lock = [], [], threading.Lock()
    for time in range(samples):
        state = RemoteState(float(time), False, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        poses._robot = SimpleNamespace(state=lambda state=state: state)  # type: ignore[assignment]
        poses._sample()
    return len(poses._times) == samples


@limit("api.diagnostics.MOST_FAULTS", at=3)
def _(faults: int, folder: Path) -> bool:
    (folder / "g.yaml").write_text("graph: g\nnodes: {T: OnPlaybackTick}\n", encoding="utf-8")
    with ge.load(folder / "g.yaml").session(log=lambda *_: None) as session:
        for number in range(faults):
            session._runner._take_peer_fault(f"{number}")
        return len(session._runner._faults) == faults


def findings_of(notes: int) -> Findings:
    findings = Findings()
    for number in range(notes):
        findings.add("N302", f"note {number}")
    return findings


@limit("cli.log_output.LONGEST", at=50)
def _(letters: int) -> bool:
    text = "x" * letters
    return log_output._Cleaned().format(logging.makeLogRecord({"msg": text})) == text


@limit("cli.import_graph.LONGEST")
def _(notes: int) -> bool:
    return "more" not in str(list(import_graph._notes(findings_of(notes))))


@limit("cli.import_report.LONGEST")
def _(remarks: int) -> bool:
    return "more" not in str(import_report._some("lost", [("a", "")] * remarks))


@limit("cli.import_urdf.LONGEST_WAIT")
def _(seconds: float, folder: Path) -> bool:
    lists: dict[str, Any] = {key: [] for key in ("allow", "assets", "package_path", "arguments", "macro", "without")}
    given = argparse.Namespace(**lists, file=folder, topic=None, node=None, timeout=seconds)
    return accepts(lambda: check_source(given), UsageError)


@limit("cli.replay.LONGEST")
def _(characters: int) -> bool:
    return replay._short("x" * (characters - 2)) == repr("x" * (characters - 2))


@limit("drawing.manual_layout.MAX_STRETCH", step=0.01)
def _(factor: float) -> bool:
    """Two boxes that do not overlap when the distance of their left sides grows by the factor."""
    distance = 100.0
    needed = factor * distance - GAP[0] - manual_layout._CLEAR
    boxes = [LayoutBox(needed, 1.0, place=(0.0, 0.0)), LayoutBox(needed, 1.0, place=(distance, 0.0))]
    return len(manual_layout._stretched(boxes)) == 2


@limit("drawing.view_model.MAX_NODES", at=3)
def _(nodes: int) -> bool:
    flat = SimpleNamespace(nodes=[None] * nodes)
    graph: Any = SimpleNamespace(flat=flat, name="g", instances=[])
    try:
        make_graph_view(graph, Findings())
    except UsageError:
        return False
    except AttributeError:  # the limit was passed; this incomplete graph cannot be drawn
        pass
    return True


@limit("drawing.view_model.FARTHEST")
def _(pixels: float) -> bool:
    return view_model._place([0.0, -pixels]) is not None


# view


@limit("view.live_findings.MOST", at=3)
def _(findings: int) -> bool:
    return len(live_findings.finding_rows([f"error G101: {number}" for number in range(findings)])) == findings


@limit("view.viewers.MAX_ASKED", at=3)
def _(requests: int) -> bool:
    made = Viewers(CommandQueue(), None, read_only=False)  # type: ignore[arg-type]
    for _ in range(requests):
        made.ask({})
    return len(made._asked) == requests


@limit("view.live_topics.MOST_TOPICS", at=3)
def _(topics: int) -> bool:
    network = SimpleNamespace(publishers=[], tap=lambda tap: None)
    claims = [EndpointClaim("/n", "g", f"/{number}", "a/msg/B", "subscribe", QoS()) for number in range(topics)]
    session: Any = SimpleNamespace(version=0, services=SimpleNamespace(network=network, claims=claims))
    return len(LiveTopics(session, None).rows(0.0)) == topics  # type: ignore[arg-type]


@limit("view.live_topics.LARGEST", at=3)
def _(size: int) -> bool:
    newest = SimpleNamespace(type="a/msg/B", latest_data=bytes(size))
    topics = LiveTopics(SimpleNamespace(version=0), lambda topic: newest)  # type: ignore[arg-type]
    topics.watch(["/a"])
    return next(topics.messages()).data is not None


@limit("view.page_server.MAX_UNREAD", at=10)
def _(characters: int) -> bool:
    aborted: list[bool] = []
    server = PageServer.__new__(PageServer)
    connection = SimpleNamespace(transport=SimpleNamespace(abort=lambda: aborted.append(True)))
    viewer = SimpleNamespace(answer=lambda text: None, unread=characters, connection=connection)
    server.viewers = {1: viewer}  # type: ignore[dict-item]
    server._answer_viewer(1, "")
    return not aborted


@limit("api.recording_page.MAX_ENTRIES", at=3)
def _(messages_: int) -> bool:
    log = ReplayLog()
    log.marks.tick = 1
    for number in range(messages_):
        log.log("warning", "", f"{number}")
    return len(log.entries) == messages_


@limit("view.html.scene_data.MAX_TRIANGLES", at=100)
def _(triangles: int) -> bool:
    corners = np.arange(9 * triangles, dtype=np.float32).reshape(-1, 3)
    surface = corners, np.arange(3 * triangles, dtype=np.int32).reshape(-1, 3)
    shape = VisibleShape("mesh", (1.0, 1.0, 1.0), 0, NOWHERE, (1.0, 1.0, 1.0, 1.0), "mesh")
    bodies, data = Bodies(["world"], [False], [shape], {"mesh": surface}), SceneData(Payload())
    trace: Any = SimpleNamespace(period=1.0)
    data.stage(SampledStage(bodies, {}, [], [0], [np.zeros((1, 7), np.float32)]), trace)
    return int(data.surfaces[0]["faces"]["count"]) == 3 * triangles


def traced(stage: Stage, poses: int = 0) -> SceneTrace:
    """Samples of a world without physics, whose bodies are points."""
    world: Any = DryWorld(stage)
    world.poses = lambda: np.zeros((poses, 7))
    services = Services(world, Network())
    return SceneTrace(SimpleNamespace(services=services, version=0, clock=SimpleNamespace(delta=1 / 60)))  # type: ignore[arg-type]


@limit("view.html.trace.MAX_BEAMS", at=100)
def _(beams: int) -> bool:
    stage = Stage()
    stage.add("/lidar", "lidar", facts={"angles": (0.0, float(beams - 1), 1.0)})
    trace = traced(stage)
    trace.sample(0)
    (lidar,) = trace.stages[0].lidars
    return len(lidar.lidar.directions[lidar.beams]) == beams


@limit("view.html.trace.MAX_BYTES", at=2800, step=28)
def _(bytes_: int) -> bool:
    trace = traced(Stage(), poses=1)
    for number in range(bytes_ // 28):
        trace.sample(2 * number)
    return len(trace.stages[0].ticks) == bytes_ // 28


@limit("view.html.trace.MAX_ROBOTS", at=2)
def _(robots: int, folder: Path) -> bool:
    fleet = f"{{use: robots/dd100.yaml, count: {robots}, per_row: 1, spacing: [2.0, 2.0]}}"
    path = folder / "fleet.yaml"
    path.write_text(f"scene: fleet\nworld: worlds/flat_grid.xml\nrobots: {{dd100: {fleet}}}\n", encoding="utf-8")
    with session(path) as sim:
        trace = SceneTrace(sim._runner.session)
        trace.sample(0)
    return len(trace.speeds) == robots


@limit("view.scene.shape_surfaces.LARGEST_TEXTURE")
def _(pixels: int) -> bool:
    encoded = shape_surfaces.encoded_texture(np.zeros((2, pixels, 3), np.uint8))
    return Image.open(io.BytesIO(encoded)).width == pixels


# nodes


@limit("nodes.data.sequences.MAX_LENGTH")
def _(elements: int) -> bool:
    return accepts(lambda: checked_length("size", elements), BadValueError)


@limit("nodes.data.sequences.MAX_LENGTH")
def _(letters: int) -> bool:
    return accepts(lambda: check_text_length("suffix", letters), BadValueError)


@limit("nodes.ros2.image_compression._LONGEST")
def _(pixels: int) -> bool:
    header, data = messages.Header(messages.Time(0, 0), ""), np.zeros(pixels, np.uint8)
    return accepts(lambda: compressed(header, "mono8", (pixels, 1), data, "jpeg"), BadValueError)


def points(number: int, position: float = 0.0) -> list[Any]:
    return [SimpleNamespace(positions=[position], velocities=[], accelerations=[], effort=[])] * number


@limit("nodes.ros2.joint_trajectory.MAX_POINTS", at=3)
def _(number: int) -> bool:
    return accepts(lambda: joint_trajectory._check_numbers(points(number), 1), TrajectoryError)


@limit("nodes.ros2.joint_trajectory._LARGEST")
def _(position: float) -> bool:
    return accepts(lambda: joint_trajectory._check_numbers(points(1, -position), 1), TrajectoryError)


@limit("nodes.ros2.transform_listener._FARTHEST")
def _(metres: float) -> bool:
    rotation = messages.Quaternion(0.0, 0.0, 0.0, 1.0)
    transform = messages.Transform(messages.Vector3(0.0, 0.0, -metres), rotation)
    return transform_listener._pose(transform) is not None


class AcceptedError(Exception):
    """A goal was accepted."""


@limit("nodes.ros2.gripper_command._LARGEST")
def _(number: float) -> bool:
    def accept() -> None:
        raise AcceptedError

    given = (0.0, -number, number, "")
    node = SimpleNamespace(
        read=lambda command: given, logger=SimpleNamespace(log=print), server=SimpleNamespace(action="/a")
    )
    goal = SimpleNamespace(message=SimpleNamespace(command=None), accept=accept, reject=lambda: None)
    return not accepts(lambda: ROS2GripperCommand.begin(node, goal), AcceptedError)  # type: ignore[arg-type]


@limit("nodes.ros2.robot_action._LARGEST")
def _(position: float) -> bool:
    node: Any = SimpleNamespace(commanded=("a",), exec_out=1)
    RobotActionNode.command(node, np.array([-position]), np.array([position]))
    return bool(node.position_command == [-position] and node.velocity_command == [position])


@limit("nodes.ros2.fields.MAX_PORTS", at=3)
def _(fields: int, folder: Path) -> bool:
    (folder / "my_msgs" / "msg").mkdir(parents=True)
    text = "".join(f"int32 field{number}\n" for number in range(fields))
    (folder / "my_msgs" / "msg" / "Long.msg").write_text(text, encoding="utf-8")
    definitions = DEFINITIONS.extended([folder])
    return accepts(lambda: Layout(definitions.message_class("my_msgs/msg/Long"), definitions).leaves, MessageTypeError)


@limit("nodes.wheeled_robots.quintic.SHORTEST_STEP", lower=True)
def _(seconds: float) -> bool:
    planner = QuinticPathPlanner(current_position=(0.0, 0.0, 0.0), current_orientation=(0.0, 0.0, 0.0, 1.0))
    planner.step = seconds
    try:
        planner.plan((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    except BadValueError as error:
        return error.port != "step"
    return True


@limit("api.video.FASTEST")
def _(rate: int) -> bool:
    return accepts(lambda: video.check_length(1.0, rate, (8, 8)), UsageError)


@limit("api.video.MAX_FRAMES")
def _(frames: int) -> bool:
    return accepts(lambda: video.check_length(frames / 10, 10, (8, 8)), UsageError)


@limit("api.video.MAX_BYTES", at=300)
def _(size: int) -> bool:
    return accepts(lambda: video.check_length(1.0, 1, (-(-size // 3), 1)), UsageError)


# experiments


@limit("experiments.scenario.MAX_CASES", at=3)
def _(cases: int, folder: Path) -> bool:
    path = folder / "tried.scenario.yaml"
    path.write_text(
        f"scenario: s\nscene: dd100_flat\nmatrix: {{seed: {list(range(cases))}}}\nexpect: [always: time < 1]\n"
    )
    return read_scenario(path, Findings()) is not None
