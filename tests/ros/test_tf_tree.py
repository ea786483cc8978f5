"""The tree of frames: how it is drawn, how it is counted, what is wrong with it."""

from __future__ import annotations

import functools
import math
from typing import Any

import pytest

from graphengine.messages import messages
from graphengine.ros.tf_tree import MAX_EDGES, FrameTree, to_dot

A, B = b"a" * 16, b"b" * 16
NAMES = {A: "/alice", B: "/bob"}


def transform(parent: str, child: str, seconds: float = 0.0) -> Any:
    zero, unit = messages.Vector3(0.0, 0.0, 0.0), messages.Quaternion(0.0, 0.0, 0.0, 1.0)
    return messages.TransformStamped(messages.header(seconds, parent), child, messages.Transform(zero, unit))


def tree(*edges: tuple[str, str], source: bytes = A) -> FrameTree:
    made = FrameTree()
    made.add(messages.TFMessage([transform(*edge) for edge in edges]), True, source)
    return made


def drawn(made: FrameTree) -> list[str]:
    return [str(row) for row in made.rows()]


def test_each_frame_is_drawn_below_its_parent() -> None:
    made = tree(("odom", "base"), ("base", "chassis"), ("chassis", "laser"), ("base", "wheel"), ("chassis", "camera"))
    assert drawn(made) == [
        "odom",
        "└─ base",
        "   ├─ chassis",
        "   │  ├─ camera",
        "   │  └─ laser",
        "   └─ wheel",
    ]
    assert made.faults(NAMES) == []


def test_a_leading_slash_does_not_change_a_frame() -> None:
    made = tree(("/odom", "/base"), ("base", "laser"))
    assert drawn(made) == ["odom", "└─ base", "   └─ laser"]


def test_the_rate_is_that_of_the_stamps() -> None:
    made = FrameTree()
    for tick in range(31):
        made.add(messages.TFMessage([transform("odom", "base", 5.0 + tick / 30)]), False, A)
    (edge,) = made.edges
    assert edge.rate == pytest.approx(30.0, rel=1e-6)
    assert (edge.number, edge.oldest, edge.newest) == (31, 5_000_000_000, 6_000_000_000)


def test_a_single_message_has_no_rate() -> None:
    (edge,) = tree(("odom", "base")).edges
    assert edge.rate is None


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"child_frame_id": ""}, "'' in 'odom' because a frame has no name"),
        ({"child_frame_id": "/odom"}, "'odom' in 'odom' because parent and child are the same frame"),
        ({"transform__translation__y": math.nan}, "'base' in 'odom' because it contains NaN"),
        ({"transform__rotation__w": 0.0}, "'base' in 'odom' because the length of its quaternion is not 1"),
        ({"transform__rotation__x": 0.2}, "'base' in 'odom' because the length of its quaternion is not 1"),
        ({"transform__rotation__w": math.nan}, "'base' in 'odom' because it contains NaN"),
    ],
)
def test_transforms_that_tf2_ignores_are_reported_once_and_left_out(changed: dict[str, Any], why: str) -> None:
    made, wrong = tree(("odom", "laser")), transform("odom", "base")
    for name, value in changed.items():
        *way, last = name.split("__")
        setattr(functools.reduce(getattr, way, wrong), last, value)
    for _ in range(2):
        made.add(messages.TFMessage([wrong]), False, B)
    assert drawn(made) == ["odom", "└─ laser"]
    assert made.faults(NAMES) == [f"tf2 ignores {why}; sent by /bob"]


def test_a_quaternion_within_the_tolerance_is_accepted() -> None:
    made, rounded = FrameTree(), transform("odom", "base")
    rounded.transform.rotation.w = 1.004  # whose square is 0.008 too large, where tf2 lets pass 0.01
    made.add(messages.TFMessage([rounded]), True, A)
    assert made.faults(NAMES) == []


def test_robots_with_prefixes_have_separate_trees() -> None:
    made = tree(("one/odom", "one/base"), ("two/odom", "two/base"))
    assert made.faults(NAMES) == []
    made.add(messages.TFMessage([transform("two/body", "two/camera")]), True, A)
    assert made.faults(NAMES) == ["the tree of two is in 2 pieces, with the roots two/body, two/odom"]


def test_a_tree_in_pieces_is_reported_with_the_roots() -> None:
    made = tree(("odom", "base"), ("chassis", "laser"))
    assert drawn(made) == ["chassis", "└─ laser", "odom", "└─ base"]
    assert made.faults(NAMES) == ["the tree is in 2 pieces, with the roots chassis, odom"]


def test_two_parents_of_a_frame_are_reported_with_their_broadcasters() -> None:
    made = tree(("odom", "base"), ("base", "laser"))
    made.add(messages.TFMessage([transform("map", "base")]), False, B)
    assert drawn(made) == ["map", "└─ base", "   └─ laser", "odom", "└─ base (above)"]
    assert made.faults(NAMES) == [
        "the tree is in 2 pieces, with the roots map, odom",
        "base has 2 parents: map (by /bob), odom (by /alice)",
    ]


def test_a_loop_is_reported_and_drawn_once() -> None:
    made = tree(("a", "b"), ("b", "c"), ("c", "a"), ("c", "d"))
    assert drawn(made) == ["a", "└─ b", "   └─ c", "      ├─ a (above)", "      └─ d"]
    assert made.faults(NAMES) == ["frames form a loop: a in c in b in a"]


def test_two_broadcasters_of_a_transform_are_reported() -> None:
    made = tree(("odom", "base"))
    made.add(messages.TFMessage([transform("odom", "base")]), False, B)
    assert made.faults(NAMES) == ["base in odom has several broadcasters: /alice, /bob"]


def test_a_long_chain_of_frames_is_drawn() -> None:
    made = tree(*((f"f{number}", f"f{number + 1}") for number in range(3000)))
    assert len(drawn(made)) == 3001
    assert made.faults(NAMES) == []


def test_transforms_beyond_the_limit_are_left_out_and_reported() -> None:
    made = tree(*(("map", f"f{number}") for number in range(MAX_EDGES + 1)))
    made.add(messages.TFMessage([transform("map", "f0")]), True, A)
    assert len(made.edges) == MAX_EDGES
    assert made.edges[0].number == 2
    assert made.faults(NAMES) == [f"there are more than {MAX_EDGES} transforms; further transforms are ignored"]


def test_dot_has_an_arrow_from_each_parent_with_its_facts() -> None:
    lines = to_dot(tree(("odom", 'ba"se\\')), NAMES).splitlines()
    assert lines[0] == "digraph frames {"
    assert lines[2] == (
        r'  "odom" -> "ba\"se\\" [label="Broadcaster: /alice\nAverage rate: static\n'
        r'Most recent transform: 0.000\nOldest transform: 0.000"];'
    )
    assert lines[-1] == "}"
