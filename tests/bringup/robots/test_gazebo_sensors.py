"""Sensors that a description has for Gazebo become entries of the robot file; what cannot be carried over is said."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from graphengine.bringup.robots.gazebo_profiles import NO_LIKE, READERS
from graphengine.bringup.robots.gazebo_sensors import MAX_SENSORS
from graphengine.bringup.robots.gazebo_topics import legal
from tests.bringup.robots.descriptions import SCAN, attempt, imported, sensor

BEAMS = {"first_deg": 0.0, "last_deg": 359.817495, "count": 360}
LIDAR = f"<update_rate>5</update_rate><lidar>{SCAN}</lidar>"


def robot(folder: Path, *gazebo: str) -> dict[str, Any]:
    """The robot file of an import."""
    *_, text = imported(folder, *gazebo).files.values()
    data = yaml.safe_load(text)
    assert isinstance(data, dict)
    return data


def remarks(folder: Path, kind: str, *gazebo: str) -> list[str]:
    """What an import says."""
    return [remark.text for remark in getattr(imported(folder, *gazebo).draft, kind)]


def profile(folder: Path, kind: str, inside: str) -> dict[str, Any]:
    """The figures of a sensor."""
    (entry,) = robot(folder, sensor("base_scan", kind, inside))["sensors"].values()
    return dict(entry["profile"])


def uses(folder: Path, *gazebo: str) -> dict[str, dict[str, Any]]:
    """Parameters of the graphs of an import's sensors, by graph."""
    graphs = [use for use in robot(folder, *gazebo)["graphs"].values() if use["use"].startswith("graphs/publishers/")]
    return {use["use"].removeprefix("graphs/publishers/").removesuffix(".yaml"): use["parameters"] for use in graphs}


@pytest.mark.parametrize(
    ("kind", "section"), [("ray", "ray"), ("gpu_ray", "ray"), ("lidar", "lidar"), ("gpu_lidar", "ray")]
)
def test_old_and_new_names_of_lidars_mean_the_same(tmp_path: Path, kind: str, section: str) -> None:
    inside = LIDAR.replace("lidar>", f"{section}>")
    assert profile(tmp_path, kind, inside) == {
        "rate": 5.0,
        "beams": BEAMS,
        "near": 0.12,
        "far": 3.5,
        "resolution": 0.015,
    }


def test_a_lidar_has_its_rings_and_noise(tmp_path: Path) -> None:
    vertical = (
        "<vertical><samples>16</samples><min_angle>-.2617994</min_angle><max_angle>.2617994</max_angle></vertical>"
    )
    noise = "<noise><type>gaussian</type><mean>0</mean><stddev>0.01</stddev></noise>"
    inside = LIDAR.replace("</scan>", f"{vertical}</scan>").replace("</lidar>", f"{noise}</lidar>")
    figures = profile(tmp_path, "gpu_lidar", inside)
    assert figures["rings"] == {"first_deg": -15.000001, "last_deg": 15.000001, "count": 16}
    assert figures["noise_std"] == 0.01
    assert list(uses(tmp_path, sensor("base_scan", "gpu_lidar", inside))) == ["points"]


def test_a_lidar_with_reversed_angles_is_reported(tmp_path: Path) -> None:
    inside = LIDAR.replace(">0<", ">1<").replace("6.28", "-1")
    beams = profile(tmp_path, "lidar", inside)["beams"]
    assert (beams["first_deg"], beams["last_deg"]) == pytest.approx((-57.29578, 57.29578))
    (told,) = [
        text for text in remarks(tmp_path, "guessed", sensor("base_scan", "lidar", inside)) if "min_angle" in text
    ]
    assert "horizontal min_angle 57.2958 degrees is above max_angle -57.2958" in told


def test_beams_that_overlap_by_rounding_go_once_around(tmp_path: Path) -> None:
    inside = LIDAR.replace(">0<", ">-3.14160<").replace("6.28", "3.14160")
    assert profile(tmp_path, "lidar", inside)["beams"] == {
        "first_deg": -180.000421,
        "last_deg": 179.999579,
        "count": 360,
    }


def test_one_ray_is_a_range_sensor(tmp_path: Path) -> None:
    figures = profile(tmp_path, "ray", LIDAR.replace(">360<", ">1<").replace("6.28", "0.1").replace("lidar>", "ray>"))
    assert figures == {
        "rate": 5.0,
        "radiation_type": "infrared",
        "field_of_view": 0.1,
        "min_range": 0.12,
        "max_range": 3.5,
        "resolution": 0.015,
    }


def test_a_sonar_is_a_range_sensor(tmp_path: Path) -> None:
    figures = profile(tmp_path, "sonar", "<sonar><min>0.02</min><max>4</max><radius>0.5</radius></sonar>")
    assert (figures["radiation_type"], figures["field_of_view"]) == ("ultrasound", 0.24871)


def test_an_imu_has_noise_and_bias(tmp_path: Path) -> None:
    axis = "<noise type='gaussian'><mean>0.1</mean><stddev>{}</stddev><bias_mean>0.2</bias_mean></noise>"
    rates = "".join(f"<{name}>{axis.format(std)}</{name}>" for name, std in zip("xyz", (0.1, 0.2, 0.1), strict=True))
    figures = profile(
        tmp_path, "imu", f"<update_rate>100</update_rate><imu><angular_velocity>{rates}</angular_velocity></imu>"
    )
    assert figures["angular_velocity_noise"] == 0.2
    assert figures["angular_velocity_bias"] == pytest.approx([0.3, 0.3, 0.3])
    classic = (
        "<imu><noise><type>gaussian</type><accel><stddev>0.5</stddev><bias_mean>0.4</bias_mean></accel></noise></imu>"
    )
    figures = profile(tmp_path, "imu", classic)
    assert (figures["acceleration_noise"], figures["acceleration_bias"]) == (0.5, [0.4, 0.4, 0.4])


def test_an_imu_has_a_bias_that_drifts_as_far_as_in_gazebo(tmp_path: Path) -> None:
    noise = (
        "<dynamic_bias_stddev>{}</dynamic_bias_stddev><dynamic_bias_correlation_time>{}</dynamic_bias_correlation_time>"
    )
    axes = "".join(f"<{axis}><noise type='gaussian'>{noise.format(1e-4, 200)}</noise></{axis}>" for axis in "xyz")
    inside = f"<imu><angular_velocity>{axes}</angular_velocity><linear_acceleration>{axes}</linear_acceleration></imu>"
    figures = profile(tmp_path, "imu", inside)
    assert figures["gyroscope"] == {"bias_instability_dph": 206.265, "bias_correlation_time": 200.0}  # 1e-3 rad/s
    assert figures["accelerometer"] == {"bias_instability_ug": 101.972, "bias_correlation_time": 200.0}  # 1e-3 m/s2


@pytest.mark.parametrize(
    ("library", "noise", "figures"),
    [
        ("gazebo_ros_imu", "<gaussianNoise>0.1</gaussianNoise>", (0.1, 0.1)),
        ("hector_gazebo_ros_imu", "<accelGaussianNoise>0.1 0.2 0.1</accelGaussianNoise>", (0.2, None)),
    ],
)
def test_an_imu_plugin_of_gazebo_classic_becomes_an_imu(
    tmp_path: Path, library: str, noise: str, figures: tuple[float, float | None]
) -> None:
    inside = f"<bodyName>imu_link</bodyName><topicName>/imu/raw</topicName><updateRate>50</updateRate>{noise}"
    plugin = f'<gazebo><plugin name="unit" filename="lib{library}.so">{inside}</plugin></gazebo>'
    unit = robot(tmp_path, plugin)["sensors"]["unit"]
    assert (unit["parent"], unit["profile"]["rate"]) == ("imu_link", 50.0)
    assert (unit["profile"]["acceleration_noise"], unit["profile"].get("angular_velocity_noise")) == figures
    assert uses(tmp_path, plugin)["imu"]["topic"] == "imu/raw"
    assert remarks(tmp_path, "lost", plugin) == []


@pytest.mark.parametrize("kind", ["navsat", "gps"])
def test_a_receiver_has_the_noise_of_its_position(tmp_path: Path, kind: str) -> None:
    noise = "<{0}><noise type='gaussian'><mean>0</mean><stddev>{1}</stddev></noise></{0}>"
    position = f"<position_sensing>{noise.format('horizontal', 1.5)}{noise.format('vertical', 2.5)}</position_sensing>"
    given = sensor("imu_link", kind, f"<update_rate>10</update_rate><{kind}>{position}</{kind}><topic>gps/fix</topic>")
    (entry,) = robot(tmp_path, given)["sensors"].values()
    assert entry == {
        "type": "navsat",
        "parent": "imu_link",
        "profile": {"rate": 10.0, "horizontal_noise": 1.5, "vertical_noise": 2.5},
    }
    assert uses(tmp_path, given)["navsat"]["topic"] == "gps/fix"
    assert remarks(tmp_path, "lost", given) == []


@pytest.mark.parametrize(
    ("inside", "figures"),
    [
        ("", {}),
        ("<frame>child</frame><measure_direction>child_to_parent</measure_direction>", {}),
        ("<frame>parent</frame>", {"axes": "parent"}),
        ("<measure_direction>parent_to_child</measure_direction>", {"measure_direction": "parent_to_child"}),
        (
            "<force><x>{0}</x></force><torque><z>{0}</z></torque>".format(
                "<noise type='gaussian'><stddev>0.2</stddev></noise>"
            ),
            {"force_noise": 0.2, "torque_noise": 0.2},
        ),
    ],
)
def test_a_force_torque_sensor_of_a_joint_is_on_its_child_link(
    tmp_path: Path, inside: str, figures: dict[str, Any]
) -> None:
    given = sensor("arm_joint", "force_torque", f"<update_rate>30</update_rate><force_torque>{inside}</force_torque>")
    data = robot(tmp_path, given)
    assert data["sensors"]["eye"] == {"type": "force_torque", "parent": "arm", "profile": {"rate": 30.0, **figures}}
    graph = uses(tmp_path, given)["force_torque"]
    frame = "base_link" if "axes" in figures else "arm"
    assert graph == {"sensor": "base_footprint/base_link/arm/eye", "topic": "wrench", "frame": frame}
    assert remarks(tmp_path, "lost", given) == []


@pytest.mark.parametrize(("frame", "turned"), [("child", False), ("sensor", True)])
def test_a_force_torque_sensor_keeps_its_orientation_only_in_the_frame_sensor(
    tmp_path: Path, frame: str, turned: bool
) -> None:
    inside = f"<pose>0 0 0.1 0 0 1.5707963</pose><force_torque><frame>{frame}</frame></force_torque>"
    entry = robot(tmp_path, sensor("scan_joint", "force_torque", inside))["sensors"]["eye"]
    assert (entry["parent"], entry["position"], "orientation" in entry) == ("base_scan", [0.0, 0.0, 0.1], turned)


def test_tags_without_content_are_not_reported_as_lost(tmp_path: Path) -> None:
    assert remarks(tmp_path, "lost", sensor("imu_link", "imu", "<update_rate>100</update_rate><imu/>")) == []


def test_a_camera_has_its_lens_and_noise(tmp_path: Path) -> None:
    inside = """<camera><horizontal_fov>1.5708</horizontal_fov><image><width>640</width><height>320</height></image>
      <clip><near>0.1</near><far>50</far></clip><noise><type>gaussian</type><stddev>0.01</stddev></noise></camera>"""
    assert profile(tmp_path, "camera", inside) == {
        "size": [640, 320],
        "fov_deg": [90.00021, 53.130271],
        "clip": [0.1, 50.0],
        "rate": 30.0,
        "colour_noise": 2.55,
    }
    assert profile(tmp_path, "depth_camera", inside)["depth"] is True


PLUGIN = '<plugin name="p" filename="libgazebo_ros_camera.so">{}</plugin>'


@pytest.mark.parametrize(
    ("kind", "inside", "graph", "topics"),
    [
        ("imu", "<topic>/demo/imu</topic>", "imu", {"topic": "demo/imu"}),
        ("imu", "", "imu", {"topic": "imu"}),
        ("imu", PLUGIN.format("<ros><remapping>~/out:=imu/raw</remapping></ros>"), "imu", {"topic": "imu/raw"}),
        (
            "imu",
            PLUGIN.format("<ros><namespace>/demo</namespace><argument>~/out:=raw</argument></ros>"),
            "imu",
            {"topic": "demo/raw"},
        ),
        ("imu", PLUGIN.format("<topicName>/imu/raw</topicName>"), "imu", {"topic": "imu/raw"}),
        ("imu", "<topic>a b//3/$(x)</topic>", "imu", {"topic": "a_b/_3/__x_"}),
        ("camera", "<topic>front/image</topic>", "camera", {"image": "front/image", "info": "front/camera_info"}),
        (
            "camera",
            "<camera><camera_info_topic>i</camera_info_topic></camera><topic>image</topic>",
            "camera",
            {"image": "image", "info": "i"},
        ),
        (
            "camera",
            PLUGIN.format("<camera_name>front</camera_name>"),
            "camera",
            {"image": "front/image_raw", "info": "front/camera_info"},
        ),
        (
            "camera",
            PLUGIN.format(
                "<cameraName>rs</cameraName><imageTopicName>rgb/image</imageTopicName>"
                "<cameraInfoTopicName>/info</cameraInfoTopicName>"
            ),
            "camera",
            {"image": "rs/rgb/image", "info": "info"},
        ),
        (
            "depth_camera",
            "<topic>depth</topic>",
            "depth_camera",
            {"depth": "depth", "points": "depth/points", "info": "camera_info"},
        ),
        (
            "rgbd_camera",
            "<topic>oak</topic>",
            "rgbd_camera",
            {"image": "oak/image", "depth": "oak/depth_image", "points": "oak/points", "info": "oak/camera_info"},
        ),
    ],
)
def test_topics_come_from_the_description(
    tmp_path: Path, kind: str, inside: str, graph: str, topics: dict[str, str]
) -> None:
    parameters = uses(tmp_path, sensor("camera_link", kind, inside))[graph]
    assert {name: parameters[name] for name in topics} == topics


def test_sensors_of_a_kind_without_topics_publish_below_their_names(tmp_path: Path) -> None:
    two = sensor("imu_link", "imu", "", name="left"), sensor("base_link", "imu", "", name="right")
    graphs = robot(tmp_path, *two)["graphs"].values()
    topics = [graph["parameters"]["topic"] for graph in graphs if graph["use"] == "graphs/publishers/imu.yaml"]
    assert topics == ["left/imu", "right/imu"]
    assert "sensors left, right: no topic: published on imu, below its name" in remarks(tmp_path, "guessed", *two)


@pytest.mark.parametrize(
    ("kind", "inside", "frame"),
    [
        ("imu", "", "camera_link"),
        ("imu", "<gz_frame_id>base_link</gz_frame_id>", "base_link"),
        ("imu", "<pose>1 0 0 0 0 0</pose><ignition_frame_id>imu_link</ignition_frame_id>", "imu_link"),
        ("imu", PLUGIN.format("<frame_name>/base_scan</frame_name>"), "base_scan"),
        ("camera", "", "camera_optical_frame"),
        ("camera", "<camera><optical_frame_id>base_scan</optical_frame_id></camera>", "base_scan"),
        ("camera", PLUGIN.format("<frameName>camera_link</frameName>"), "camera_optical_frame"),
    ],
)
def test_the_frame_of_a_sensor_is_a_link_with_its_pose(tmp_path: Path, kind: str, inside: str, frame: str) -> None:
    (parameters,) = uses(tmp_path, sensor("camera_link", kind, inside)).values()
    assert parameters["frame"] == frame


@pytest.mark.parametrize(
    ("kind", "inside", "frame"),
    [
        ("imu", "<pose>1 0 0 0 0 0</pose>", {"child": "eye_frame", "position": [1.0, 0.0, 0.0]}),
        ("imu", "<frame_id>bot::link::imu</frame_id>", {"child": "bot/link/imu"}),
        (
            "camera",
            "<pose>1 0 0 0 0 0</pose>",
            {"child": "eye_optical_frame", "position": [1.0, 0.0, 0.0], "orientation": [0.5, -0.5, 0.5, -0.5]},
        ),
    ],
)
def test_a_frame_that_is_no_link_is_published(tmp_path: Path, kind: str, inside: str, frame: dict[str, Any]) -> None:
    graphs = uses(tmp_path, sensor("camera_link", kind, inside))
    assert graphs["frame"] == {"parent": "camera_link", **frame}
    assert graphs[kind]["frame"] == frame["child"]


def test_a_sensor_may_be_called_like_a_link_or_another_sensor(tmp_path: Path) -> None:
    three = (sensor("imu_link", "imu", "", name=name) for name in ("imu_link", "imu_link", "scan-joint"))
    assert list(robot(tmp_path, *three)["sensors"]) == ["imu_link_imu", "imu_link_imu_2", "scan_joint_imu"]


@pytest.mark.parametrize("kind", sorted(NO_LIKE))
def test_a_sensor_type_without_an_equivalent_is_reported_as_lost(tmp_path: Path, kind: str) -> None:
    assert remarks(tmp_path, "lost", sensor("imu_link", kind, "")) == [
        f"sensor eye: there is nothing like {NO_LIKE[kind]}"
    ]


@pytest.mark.parametrize(
    ("link", "kind", "inside", "lost"),
    [
        ("nowhere", "imu", "", "the robot has no link 'nowhere'"),
        ("", "imu", "", "its <gazebo> names no link"),
        ("imu_link", "radar", "", "there is nothing like a sensor of type 'radar'"),
        ("imu_link", "contact", "", "link 'imu_link' has no collider to feel contacts"),
        ("base_footprint", "force_torque", "", "link 'base_footprint' has no joint at which to measure"),
        (
            "arm_joint",
            "force_torque",
            "<force_torque><frame>world</frame></force_torque>",
            "frame must be one of child, parent, sensor, not 'world'",
        ),
        ("imu_link", "ray", "", "the sensor has no <scan><horizontal>"),
        ("imu_link", "lidar", LIDAR.replace("360", "nan"), "samples is not a number: 'nan'"),
        ("imu_link", "lidar", LIDAR.replace("360", "-3"), "-3 samples: not a valid number of rays"),
        ("imu_link", "lidar", LIDAR.replace("360", "1e99"), "1e+99 samples: not a valid number of rays"),
        (
            "imu_link",
            "lidar",
            LIDAR.replace("360", "9999999"),
            "beams.count: Input should be less than or equal to 500000",
        ),
        (
            "imu_link",
            "lidar",
            LIDAR.replace("3.5", "0.01"),
            "near must be less than far, but 0.12 is not less than 0.01",
        ),
        ("imu_link", "imu", "<update_rate>1e9</update_rate>", "rate: Input should be less than or equal to 10000"),
        ("imu_link", "imu", "<pose>1 2 x</pose>", "pose '1 2 x' is not six valid numbers in m and rad"),
        ("imu_link", "imu", "<pose>1e99 0 0 0 0 0</pose>", "is not six valid numbers in m and rad"),
        (
            "imu_link",
            "camera",
            "<camera><horizontal_fov>7</horizontal_fov></camera>",
            "horizontal_fov 7 rad: a pinhole camera needs a value between 0 and pi",
        ),
        (
            "imu_link",
            "camera",
            "<camera><image><width>0</width></image></camera>",
            "image width 0 is not a valid number of pixels",
        ),
        ("imu_link", "sonar", "<sonar><max>-1</max></sonar>", "the maximum range must be greater than 0 m"),
    ],
)
def test_an_invalid_sensor_is_reported_as_lost_with_the_reason(
    tmp_path: Path, link: str, kind: str, inside: str, lost: str
) -> None:
    result = imported(tmp_path, sensor(link, kind, inside))
    remark = result.draft.lost[-1]
    assert lost in remark.text
    assert remark.span is not None
    assert "eye" not in result.draft.sensors


def test_unsupported_properties_of_a_sensor_are_reported_as_lost(tmp_path: Path) -> None:
    lens = "<lens><type>fisheye</type></lens><distortion><k1>0.1</k1><k2>0</k2></distortion>"
    inside = f"<visualize>1</visualize><camera>{lens}</camera>"
    assert remarks(tmp_path, "lost", sensor("camera_link", "camera", inside)) == ["sensor eye: not used: type, k1"]


def test_sensors_that_share_a_reason_share_a_remark(tmp_path: Path) -> None:
    two = (sensor("imu_link", min(NO_LIKE), "", name=name) for name in ("left", "right"))
    assert remarks(tmp_path, "lost", *two) == [f"sensors left, right: there is nothing like {NO_LIKE[min(NO_LIKE)]}"]


def screen(width: float) -> str:
    """A link with a wall, centred 0.2 m ahead of the lidar, that blocks the beams to both sides as far as it is wide."""
    return f"""<link name="screen"><collision><geometry><box size=".02 {width} .4"/></geometry></collision></link>
      <joint name="screen_joint" type="fixed">
        <parent link="base_link"/><child link="screen"/><origin xyz=".11 0 .2"/>
      </joint>"""


@pytest.mark.parametrize(("half_angle", "sees"), [(30.0, None), (45.0, False)])
def test_a_lidar_whose_beams_its_own_robot_blocks_does_not_see_the_robot(
    tmp_path: Path, half_angle: float, sees: bool | None
) -> None:
    gazebo = screen(0.4 * math.tan(math.radians(half_angle))), sensor("base_scan", "lidar", LIDAR, name="front")
    (entry,) = robot(tmp_path, *gazebo)["sensors"].values()
    assert entry.get("sees_own_robot") is sees
    (told,) = [text for text in remarks(tmp_path, "noticed", *gazebo) if "blocks" in text]
    assert told.startswith(
        f"the robot itself blocks {2 * half_angle / 360:.0%} of the beams of front within 0.5 m, by: screen"
    )
    assert told.endswith("its beams pass through the robot") is (sees is False)


def test_the_number_of_sensors_is_bounded(tmp_path: Path) -> None:
    many = [sensor("imu_link", min(NO_LIKE), "", name=f"s{number}") for number in range(MAX_SENSORS + 2)]
    assert remarks(tmp_path, "lost", *many)[0] == f"sensors after the first {MAX_SENSORS}"


TAGS = """lidar ray scan horizontal vertical samples resolution min_angle max_angle range min max noise type mean stddev
  bias_mean imu angular_velocity linear_acceleration x accel camera image width height format clip near far
  horizontal_fov pose topic update_rate plugin ros remapping namespace frame_id sonar radius contact mu1 mu2 fdir1
  material visual diffuse gravity navsat gps position_sensing force_torque frame
  measure_direction force torque"""
WORDS = st.sampled_from(
    ["", "0", "1", "-1", "360", "1e9", "1e308", "nan", "inf", "x", "gaussian", "~/out:=a", "1 0 0", "/", "::"]
)
TREES = st.recursive(
    st.tuples(st.sampled_from(TAGS.split()), WORDS).map(lambda leaf: "<{0}>{1}</{0}>".format(*leaf)),
    lambda inner: st.tuples(st.sampled_from(TAGS.split()), st.lists(inner, max_size=4)).map(
        lambda node: f"<{node[0]}>{''.join(node[1])}</{node[0]}>"
    ),
    max_leaves=12,
)


@settings(max_examples=150)
@given(kind=st.sampled_from(sorted(READERS)), inside=st.lists(TREES, max_size=4), around=TREES)
def test_an_import_survives_any_content_of_a_sensor(
    tmp_path_factory: pytest.TempPathFactory, kind: str, inside: list[str], around: str
) -> None:
    folder = tmp_path_factory.getbasetemp()
    link = f'<gazebo reference="base_link">{around}</gazebo>'
    found, findings = attempt(folder, sensor("camera_link", kind, "".join(inside)), link)
    assert found is not None, findings.items


def test_the_default_topic_of_gazebo_is_no_name() -> None:
    assert legal("__default_topic__") == ""
    assert legal("/front/scan") == "front/scan"
