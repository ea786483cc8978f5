"""Paths to prims: what they mean, what is optional, what is told when they mean nothing."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.stage import Stage
from graphengine.format.errors import AmbiguousPrimError, PrimError
from graphengine.format.prim_paths import normalize

BASE = "/dd100/Geometry/base_link"
CHASSIS = f"{BASE}/chassis_link"


@pytest.fixture
def stage() -> Stage:
    made = Stage()
    made.add("/dd100", "robot", namespace="fleet", facts={"base_link": BASE, "articulation_root": CHASSIS})
    made.add(BASE, "link", namespace="dd100_0000")
    made.add(CHASSIS, "link")
    made.add(f"{CHASSIS}/sim_lidar/Lidar", "lidar", namespace="front")
    made.add("/dd100/Physics/left_wheel_joint", "joint")
    made.add("/World/clock", "graph")
    return made


@pytest.mark.parametrize(
    ("path", "meaning"),
    [
        (BASE, BASE),
        ("/dd100/base_link", BASE),
        ("/dd100/base_link/chassis_link/sim_lidar/Lidar", f"{CHASSIS}/sim_lidar/Lidar"),
        ("//dd100/Geometry//base_link/", BASE),
        ("/dd100/Geometry", "/dd100/Geometry"),
        ("/", "/"),
    ],
)
def test_geometry_may_be_left_out_of_a_path(stage: Stage, path: str, meaning: str) -> None:
    assert stage.find(path).path == meaning
    assert path in stage


@pytest.mark.parametrize(
    "path", ["/dd100/Geometry/base_link/Geometry", "/dd100/Geometry/Physics", "/Geometry/World/clock"]
)
def test_geometry_may_not_be_put_in_where_there_is_none(stage: Stage, path: str) -> None:
    with pytest.raises(PrimError):
        stage.find(path)
    assert path not in stage


@pytest.mark.parametrize(
    ("path", "meaning"),
    [
        ("/dd100/chassis_link", CHASSIS),
        ("/dd100/Geometry/chassis_link", CHASSIS),
        ("/dd100/chassis_link/sim_lidar/Lidar", f"{CHASSIS}/sim_lidar/Lidar"),
        ("/World/robot/chassis_link", "/World/robot/Geometry/base_link/chassis_link"),
    ],
)
def test_a_link_is_found_directly_below_its_robot(stage: Stage, path: str, meaning: str) -> None:
    stage.add("/World/robot", "robot")
    stage.add("/World/robot/Geometry/base_link", "link")
    stage.add("/World/robot/Geometry/base_link/chassis_link", "link")
    assert stage.find(path).path == meaning
    assert path in stage
    assert not stage.is_literal(path, stage.find(path))


@pytest.mark.parametrize("path", ["/dd100/sim_lidar", "/dd100/chassis_link/wheel", "/chassis_link", "/World/base_link"])
def test_only_a_link_is_found_by_a_path_without_the_prims_above_it(stage: Stage, path: str) -> None:
    with pytest.raises(PrimError):
        stage.find(path)
    assert path not in stage


def test_a_link_whose_name_is_not_unique_is_not_found_directly_below_its_robot(stage: Stage) -> None:
    for side in ("left", "right"):
        stage.add(f"{CHASSIS}/{side}", "link")
        stage.add(f"{CHASSIS}/{side}/tip", "link")
    with pytest.raises(AmbiguousPrimError) as caught:
        stage.find("/dd100/tip")
    assert caught.value.help == (f"write one of: {CHASSIS}/left/tip, {CHASSIS}/right/tip",)
    assert "/dd100/tip" not in stage
    assert stage.find(f"{CHASSIS}/left/tip").name == "tip"


def test_a_path_that_matches_two_prims_is_an_error_that_names_both(stage: Stage) -> None:
    stage.add("/w/Geometry/a/b", "link")
    stage.add("/w/a/Geometry/b", "link")
    with pytest.raises(AmbiguousPrimError) as caught:
        stage.find("/w/a/b")
    assert caught.value.code == "G302"
    assert caught.value.help == ("write one of: /w/Geometry/a/b, /w/a/Geometry/b",)
    assert "/w/a/b" not in stage
    assert stage.find("/w/Geometry/a/b").path == "/w/Geometry/a/b"


@pytest.mark.parametrize(
    ("path", "message", "help"),
    [
        ("/dd10", "no prim at '/dd10': / has no child 'dd10'", "did you mean 'dd100'?"),
        (f"{CHASSIS}/sim_lidr/Lidar", f"{CHASSIS} has no child 'sim_lidr'", "did you mean 'sim_lidar'?"),
        ("/dd100/base_lnk", "/dd100 has no child 'base_lnk'", "did you mean 'base_link'?"),
        ("/dd100/Physics/arm", "/dd100/Physics has no child 'arm'", "children of /dd100/Physics: left_wheel_joint"),
        ("/dd100/Lidar", "/dd100 has no child 'Lidar'", f"'Lidar' is at: {CHASSIS}/sim_lidar/Lidar"),
    ],
)
def test_the_error_of_an_unknown_path_names_similar_prims(stage: Stage, path: str, message: str, help: str) -> None:
    with pytest.raises(PrimError) as caught:
        stage.find(path)
    assert caught.value.code == "G301"
    assert message in caught.value.message
    assert help in caught.value.help


@pytest.mark.parametrize("path", ["", "dd100", "dd100/base_link", "/dd100/../dd100", "/./dd100"])
def test_relative_paths_and_dots_in_paths_are_refused(stage: Stage, path: str) -> None:
    with pytest.raises(PrimError, match="prim path"):
        stage.find(path)


def test_a_prim_is_defined_once_and_missing_ancestors_are_scopes(stage: Stage) -> None:
    assert stage.find("/dd100/Geometry").kind == stage.find("/World").kind == "scope"
    with pytest.raises(PrimError, match=f"two prims at {BASE}"):
        stage.add(BASE, "link")
    with pytest.raises(PrimError):
        stage.add("/", "scope")
    stage.add("/World", "body", body="world")
    assert (stage.find("/World").kind, stage.find("/World").body) == ("body", "world")


def test_a_removed_prim_is_gone_together_with_all_prims_below(stage: Stage) -> None:
    stage.remove("/dd100/base_link")
    assert f"{CHASSIS}/sim_lidar/Lidar" not in stage
    assert "/dd100/base_link" not in stage
    assert "/dd100/Physics/left_wheel_joint" in stage
    stage.add(BASE, "link")
    assert stage.find("/dd100/base_link").kind == "link"


def test_prims_come_depth_first_in_order_of_definition(stage: Stage) -> None:
    assert [prim.name for prim in stage.prims()] == [
        *("", "dd100", "Geometry", "base_link", "chassis_link", "sim_lidar", "Lidar", "Physics", "left_wheel_joint"),
        *("World", "clock"),
    ]
    assert [prim.name for prim in stage.prims("link")] == ["base_link", "chassis_link"]


def test_robot_prim_base_link_and_articulation_root_identify_the_robot(stage: Stage) -> None:
    robot = stage.find("/dd100")
    stands = [prim.path for prim in stage.prims() if stage.stands_for_robot(prim) is robot]
    assert stands == ["/dd100", BASE, CHASSIS]
    assert stage.robot_of(stage.find(f"{CHASSIS}/sim_lidar/Lidar")) is robot
    assert stage.robot_of(stage.find("/World/clock")) is None


@pytest.mark.parametrize(
    ("path", "namespaces"),
    [
        ("/World/clock", []),
        ("/dd100", ["fleet"]),
        (f"{CHASSIS}/sim_lidar/Lidar", ["fleet", "dd100_0000", "front"]),
        (f"{CHASSIS}/cmd_vel/SubscribeTwist", ["fleet", "dd100_0000"]),
        ("/dd100/base_link/chassis_link/sim_lidar/Lidar", ["fleet", "dd100_0000", "front"]),
        ("/dd100/chassis_link/graph/node", ["fleet", "dd100_0000"]),
        ("/elsewhere/x", []),
    ],
)
def test_namespaces_are_collected_from_the_root_down_to_a_path_that_need_not_exist(
    stage: Stage, path: str, namespaces: list[str]
) -> None:
    assert stage.namespaces(path) == namespaces


def test_geometry_has_a_namespace_even_where_a_path_leaves_it_out(stage: Stage) -> None:
    stage.find("/dd100/Geometry").namespace = "shape"
    assert stage.namespaces("/dd100/base_link/x") == ["fleet", "shape", "dd100_0000"]


@pytest.mark.parametrize(
    ("path", "place"),
    [
        ("/dd100/base_link/chassis_link/scan/Node", f"{CHASSIS}/scan/Node"),
        ("/World/graphs", "/World/graphs"),
        ("/dd100/base_link", BASE),
    ],
)
def test_a_prim_is_defined_below_the_existing_prims_of_its_path(stage: Stage, path: str, place: str) -> None:
    assert stage.define(path).path == place
    assert stage.find(path).path == stage.define(path).path == place


@pytest.mark.parametrize(
    ("path", "other", "expected"),
    [
        (f"{CHASSIS}/scan/Node", "/dd100/base_link/chassis_link/scan", True),
        ("/dd100/base_link/chassis_link/scan/Node", f"{CHASSIS}/scan/Node", True),
        ("/dd100/base_link/chassis_link/scan/Node", "/dd100/base_link", True),
        ("/World/graphs/one/Node", "/World/graphs", True),
        ("/World/graphs/one/Node", "/World/graphs/two", False),
        ("/World/graphs/one/Node", "/World/graph", False),
        ("/World/graphs/one", "/World/graphs/one/Node", False),
        ("/World/graphs/one", "/dd100", False),
    ],
)
def test_a_path_can_lie_below_a_prim_that_does_not_exist(stage: Stage, path: str, other: str, expected: bool) -> None:
    assert stage.leads_by(path, other) is expected


NAME = st.sampled_from(["a", "b", "Geometry", "c"])


@given(st.lists(st.lists(NAME, min_size=1, max_size=5), max_size=12), st.lists(NAME, min_size=1, max_size=5))
def test_a_short_path_finds_a_prim_only_if_nothing_but_geometry_is_left_out(
    paths: list[list[str]], wanted: list[str]
) -> None:
    stage = Stage()
    for parts in paths:
        if "/" + "/".join(parts) not in [prim.path for prim in stage.prims()]:
            stage.add("/" + "/".join(parts), "frame")
    path = "/" + "/".join(wanted)
    meant = {prim.path for prim in stage.prims() if leaves_out(wanted, prim.path.strip("/").split("/"))}
    if path in meant:
        meant = {path}
    try:
        assert {stage.find(path).path} == meant
    except AmbiguousPrimError:
        assert len(meant) > 1
    except PrimError:
        assert meant == set()


def leaves_out(wanted: list[str], parts: list[str]) -> bool:
    if not parts or not wanted:
        return wanted == [part for part in parts if part != "Geometry"]
    return (wanted[0] == parts[0] and leaves_out(wanted[1:], parts[1:])) or (
        parts[0] == "Geometry" and leaves_out(wanted, parts[1:])
    )


@given(st.lists(NAME, min_size=1, max_size=4), st.integers(1, 3))
def test_doubled_and_trailing_slashes_change_nothing(parts: list[str], slashes: int) -> None:
    path = "/" + "/".join(parts)
    assert normalize(path.replace("/", "/" * slashes) + "/" * slashes) == path


def test_a_tree_is_like_its_copy_until_a_prim_differs(stage: Stage) -> None:
    other = stage.copy()
    assert stage.is_like(other)
    other.find(CHASSIS).facts["mass"] = 1.0
    assert not stage.is_like(other)
    del other.find(CHASSIS).facts["mass"]
    other.add("/World/more", "scope")
    assert not stage.is_like(other)
    assert not other.is_like(stage)
