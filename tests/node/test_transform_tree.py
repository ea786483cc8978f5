"""Targets to edges of a TF tree, and what their frames are called."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from graphengine.devices.dry_world import DryWorld
from graphengine.devices.stage import Prim, Stage
from graphengine.node.context.transform_tree import expand, frame_names


def named(*paths: str, **overrides: str) -> dict[str, str]:
    """Frame names by path; an override is given by the path's last element."""
    prims = [Prim(path, "frame", None, name_override=overrides.get(path.rpartition("/")[2], "")) for path in paths]
    return {prim.path: name for prim, name in frame_names(Stage(), prims).items()}


def edges(stage: Stage, *targets: str, parent: str = "") -> list[tuple[str, str]]:
    links = expand(
        stage, [stage.find(t) for t in targets], stage.find(parent) if parent else None, DryWorld(stage).frame
    )
    return [(link.parent_name, link.child_name) for link in links]


# Names


def test_a_frame_has_the_name_of_its_override_or_else_the_last_element_of_its_path() -> None:
    assert named("/a/base", "/a/lidar", lidar="front_lidar") == {"/a/base": "base", "/a/lidar": "front_lidar"}


def test_of_prims_with_equal_names_the_prim_with_the_longest_path_keeps_the_name() -> None:
    assert named("/robot/lidar", "/robot/base/lidar") == {"/robot/base/lidar": "lidar", "/robot/lidar": "robot_lidar"}


def test_of_prims_with_equally_long_paths_the_first_keeps_the_name() -> None:
    assert named("/r/a/x", "/r/b/x") == {"/r/a/x": "x", "/r/b/x": "b_x"}


def test_a_prim_whose_name_is_taken_gets_its_last_element_or_an_ancestor_before_it() -> None:
    assert named("/r/left", "/r/right/arm", left="tool", arm="tool") == {"/r/right/arm": "tool", "/r/left": "left"}
    paths = ("/r/a1/b/x", "/r/a2/b/x", "/r/a2/c/x")
    assert named(*paths) == dict(zip(paths, ("x", "a2_x", "c_x"), strict=True))


def test_if_all_shorter_names_are_taken_a_frame_is_named_by_its_whole_path() -> None:
    assert named("/a/x", "/b/x") == {"/a/x": "x", "/b/x": "b_x"}


paths = st.lists(st.sampled_from("abc"), min_size=1, max_size=4).map(lambda parts: "/" + "/".join(parts))


@given(st.lists(paths), st.dictionaries(st.sampled_from("abc"), st.sampled_from(["", "a", "shared"])))
def test_all_frames_have_different_names(paths: list[str], overrides: dict[str, str]) -> None:
    names = named(*paths, **overrides)
    assert len(names) == len(set(names.values())) == len(set(paths))


# Edges


def robot() -> Stage:
    stage = Stage()
    base = "/r/Geometry/base"
    stage.add("/r", "robot", facts={"base_link": base, "articulation_root": f"{base}/chassis"})
    stage.add(base, "link")
    stage.add(f"{base}/chassis", "link")
    stage.add(f"{base}/chassis/mount/wheel", "link")
    stage.add(f"{base}/chassis/lidar", "lidar")
    stage.add("/box", "body")
    return stage


def test_a_prim_gives_one_edge_to_the_parent_or_the_world() -> None:
    assert edges(robot(), "/r/base/chassis/lidar") == [("world", "lidar")]
    assert edges(robot(), "/r/base/chassis/lidar", "/box", parent="/r/base") == [("base", "lidar"), ("base", "box")]


def test_a_target_that_stands_for_a_robot_gives_each_link_an_edge_from_the_nearest_link_above() -> None:
    whole = [("world", "base"), ("base", "chassis"), ("chassis", "wheel")]
    assert edges(robot(), "/r") == edges(robot(), "/r/base") == edges(robot(), "/r/base/chassis") == whole


def test_a_link_that_does_not_stand_for_the_robot_gives_one_edge() -> None:
    assert edges(robot(), "/r/base/chassis/mount/wheel", parent="/r/base") == [("base", "wheel")]


def test_the_parent_is_no_child_of_itself() -> None:
    assert edges(robot(), "/r", parent="/r/base/chassis") == [("chassis", "base"), ("chassis", "wheel")]


def test_overrides_name_both_ends_of_an_edge() -> None:
    stage = robot()
    stage.find("/r/base").name_override, stage.find("/r/base/chassis/lidar").name_override = "base_frame", "laser_frame"
    assert edges(stage, "/r/base/chassis/lidar", parent="/r/base") == [("base_frame", "laser_frame")]


def test_a_prim_that_is_a_target_twice_gives_one_edge() -> None:
    assert edges(robot(), "/box", "/r", "/box", "/r/base") == [
        *(("world", "box"), ("world", "base"), ("base", "chassis"), ("chassis", "wheel"))
    ]
