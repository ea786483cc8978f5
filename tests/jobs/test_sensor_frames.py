"""What sensors tell, put into the world by the TF of the same stamp, is where the world is; while the robot drives a curve."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.jobs.harness import Job, nanoseconds
from tests.physics.pictures.harness import needs_opengl

pytestmark = needs_opengl

CENTRE, HALF, TURN = np.array([2.0, 0.3, 0.4]), np.array([0.2, 0.3, 0.4]), math.radians(25.0)
"""Of a box on the floor, m; it is turned about the vertical."""
SIZE = (160, 100)
CAMERA = "Geometry/base_link/chassis_link/sim_camera/RSD455/Camera_OmniVision_OV9782_Color"
LIDAR = "Geometry/base_link/chassis_link/sim_lidar"
ROOF = "Geometry/base_link/chassis_link/roof"

FILES = {
    "world.xml": f"""<mujoco><worldbody>
      <geom name="floor" type="plane" size="0 0 1" friction="0.8"/>
      <body name="box" pos="{CENTRE[0]} {CENTRE[1]} {CENTRE[2]}" euler="0 0 25">
        <geom type="box" size="{HALF[0]} {HALF[1]} {HALF[2]}"/>
      </body>
    </worldbody></mujoco>""",
    "robot.yaml": f"""
robot: seeing
extends: robots/dd100.yaml
sensors:
  roof:
    type: lidar
    profile: lidar_3d_16
    noise_std: 0.0
    parent: base_link/chassis_link
    position: [-0.1, 0.05, 0.5]
    orientation: {{rpy_deg: [5, 12, 100]}}
graphs:
  camera: {{use: graphs/camera.yaml, parameters: {{width: {SIZE[0]}, height: {SIZE[1]}}}}}
  cloud: {{use: cloud.yaml}}
""",
    "cloud.yaml": f"""
graph: cloud
at: $(robot)/Geometry/base_link/cloud
parameters: {{robot: {{type: target, default: /dd100}}}}
nodes:
  Tick: OnPlaybackTick
  Time: ReadSimulationTime
  Product: {{type: CreateRenderProduct, inputs: {{cameraPrim: $(robot)/{CAMERA}, width: {SIZE[0]}, height: {SIZE[1]}}}}}
  Points: {{type: CameraHelper, inputs: {{type: depth_pcl, topicName: points}}}}
  Prims: {{type: CameraHelper, inputs: {{type: instance_segmentation, topicName: prims, enableSemanticLabels: true}}}}
  Rings: {{type: CreateRenderProduct, inputs: {{cameraPrim: $(robot)/{ROOF}/Lidar}}}}
  Around: {{type: RtxLidarHelper, inputs: {{type: point_cloud, topicName: around, frameId: roof}}}}
  Context: {{type: ROS2Context, inputs: {{domain_id: 7}}}}    # apart from the robot's own transforms
  Frames:
    type: PublishTransformTree
    inputs: {{targetPrims: [$(robot)/{CAMERA}, $(robot)/{LIDAR}, $(robot)/{ROOF}]}}
connections:
  - Tick.tick -> Product.execIn
  - Product.execOut -> Points.execIn
  - Product.execOut -> Prims.execIn
  - Product.renderProductPath -> Points.renderProductPath
  - Product.renderProductPath -> Prims.renderProductPath
  - Tick.tick -> Rings.execIn
  - Rings.execOut -> Around.execIn
  - Rings.renderProductPath -> Around.renderProductPath
  - Context.context -> Frames.context
  - Tick.tick -> Frames.execIn
  - Time.simulationTime -> Frames.timeStamp
""",
    "scene.yaml": """
scene: box
world: world.xml
physics: {tick_rate: 60, substeps: 4}
settle: true
robots:
  dd100: {use: robot.yaml, position: [0.0, 0.0, 0.02], orientation: {rpy_deg: [0, 0, 10]}}
""",
}


@pytest.fixture(scope="module")
def heard(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Job]:
    folder = tmp_path_factory.mktemp("frames")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    with Job(Path(folder / "scene.yaml")) as job:
        job.drive("/dd100_0000/cmd_vel", 0.8, 0.4, 0.7)
        yield job


def rotation_matrix(q: Any) -> NDArray[np.float64]:
    """Of a unit quaternion: (w^2 - u.u) 1 + 2 u u^T + 2 w [u]x."""
    u = np.array([q.x, q.y, q.z])
    cross = np.array([[0.0, -q.z, q.y], [q.z, 0.0, -q.x], [-q.y, q.x, 0.0]])
    turned: NDArray[np.float64] = (q.w**2 - u @ u) * np.eye(3) + 2.0 * np.outer(u, u) + 2.0 * q.w * cross
    return turned


def frame_at(job: Job, name: str, stamp: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rotation and place of a frame in the world at a time."""
    edges = (edge for message in job.heard("/dd100_0000/tf") for edge in message.transforms)
    (edge,) = (
        edge
        for edge in edges
        if (edge.header.frame_id, edge.child_frame_id, nanoseconds(edge.header.stamp)) == ("world", name, stamp)
    )
    place = edge.transform.translation
    return rotation_matrix(edge.transform.rotation), np.array([place.x, place.y, place.z])


def above_the_box(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Signed distance of points of the world from the box's surface, m; negative within."""
    c, s = math.cos(TURN), math.sin(TURN)
    local = (points - CENTRE) @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    beyond = np.abs(local) - HALF
    distance: NDArray[np.float64] = np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(
        beyond.max(axis=1), 0.0
    )
    return distance


def test_it_is_a_curve_that_is_driven(heard: Job) -> None:
    odometry = heard.newest("/dd100_0000/odom")
    assert odometry.twist.twist.linear.x > 0.3
    assert odometry.twist.twist.angular.z > 0.1


def test_the_cameras_points_lie_on_the_box_and_on_the_floor(heard: Job) -> None:
    cloud = heard.newest("/dd100_0000/sim_camera/points")
    rotation, place = frame_at(heard, "Camera_OmniVision_OV9782_Color", nanoseconds(cloud.header.stamp))
    points = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 3) @ rotation.T + place
    on_the_floor = np.abs(points[:, 2]) < 1e-4
    assert np.abs(above_the_box(points[~on_the_floor])).max() < 1e-4
    assert min(on_the_floor.sum(), (~on_the_floor).sum()) > 1000


def test_a_lidars_ranges_end_on_the_box(heard: Job) -> None:
    scan = heard.newest("/dd100_0000/sim_lidar/scan")
    rotation, place = frame_at(heard, "sim_lidar", nanoseconds(scan.header.stamp))
    azimuth = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    hit = np.isfinite(scan.ranges)
    ends = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(len(azimuth))], axis=1)[hit] * scan.ranges[hit, None]
    points = ends @ rotation.T + place
    on_the_floor = np.abs(points[:, 2]) < 1e-4
    assert np.abs(above_the_box(points[~on_the_floor])).max() < 1e-4
    assert (~on_the_floor).sum() > 50


def test_the_points_of_a_tilted_3d_lidar_lie_on_the_box_and_on_the_floor(heard: Job) -> None:
    cloud = heard.newest("/dd100_0000/around")
    rotation, place = frame_at(heard, "roof", nanoseconds(cloud.header.stamp))
    points = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, cloud.point_step // 4)[:, :3] @ rotation.T + place
    on_the_floor = np.abs(points[:, 2]) < 1e-4
    assert np.abs(above_the_box(points[~on_the_floor])).max() < 1e-4
    assert on_the_floor.sum() > 1000
    assert (~on_the_floor).sum() > 100


def test_the_boxs_outline_is_where_the_calibration_projects_it(heard: Job) -> None:
    prims, info = (heard.newest(f"/dd100_0000/sim_camera/{name}") for name in ("prims", "camera_info"))
    assert prims.header.stamp == info.header.stamp
    labels = json.loads(heard.newest("/dd100_0000/sim_camera/semantic_labels").data)
    (number,) = (int(key) for key, label in labels.items() if label.get("class") == "/World/box")
    seen = np.frombuffer(bytes(prims.data), "<i4").reshape(prims.height, prims.width) == number
    rotation, place = frame_at(heard, "Camera_OmniVision_OV9782_Color", nanoseconds(prims.header.stamp))
    within = distance_within(outline(info, rotation, place), SIZE)
    assert seen[within > 0.1].all()
    assert not seen[within < -0.1].any()
    assert (within > 0.1).sum() > 500


def outline(info: Any, rotation: NDArray[np.float64], place: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pixels of the box's corners, by P of the calibration."""
    c, s = math.cos(TURN), math.sin(TURN)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = CENTRE + signs * HALF @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    optical = (corners - place) @ rotation
    projected = np.c_[optical, np.ones(8)] @ info.p.reshape(3, 4).T
    pixels: NDArray[np.float64] = projected[:, :2] / projected[:, 2:]
    return pixels


def distance_within(corners: NDArray[np.float64], size: tuple[int, int]) -> NDArray[np.float64]:
    """How far each pixel's middle is within the convex hull of some points, pixels; negative outside."""
    grid = np.stack(np.meshgrid(*map(np.arange, size)), axis=-1)
    distance = np.full(grid.shape[:2], math.inf)
    for a in corners:
        for b in corners:
            along = b - a
            length = np.linalg.norm(along)
            if length == 0.0:
                continue
            inward = np.array([-along[1], along[0]]) / length
            if ((corners - a) @ inward >= -1e-9).all():  # an edge of the hull
                distance = np.minimum(distance, (grid - a) @ inward)
    return distance
