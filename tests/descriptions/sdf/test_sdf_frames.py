"""Where frames lie: the numbers are those of the specification's "Pose Frame Semantics" and of libsdformat's own tests."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.descriptions.sdf.sdf_values import SdfError
from graphengine.devices.rotation import from_rpy, multiply, to_rpy
from tests.descriptions.sdf.harness import document, frame, joint, link, model, place, pose, scope, six

QUARTER = math.pi / 2
RELATIVE_TO_JOINT = document(
    model(
        link("P", pose(1))
        + link("C", pose(2, 0, 0, 0, QUARTER))
        + joint("J", "P", "C", pose(0, 3, 0, 0, -QUARTER))
        + f'<frame name="F1">{pose(0, 0, 1, relative_to="P")}</frame>'
        + f'<frame name="F2">{pose(0, 0, 2, relative_to="C")}</frame>'
        + f'<frame name="F3">{pose(0, 0, 3, 0, QUARTER, relative_to="J")}</frame>'
        + f'<frame name="F4">{pose(0, 0, 4, 0, -QUARTER, relative_to="F3")}</frame>'
    ),
    "1.7",
)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("__model__", (0, 0, 0, 0, 0, 0)),
        ("P", (1, 0, 0, 0, 0, 0)),
        ("C", (2, 0, 0, 0, QUARTER, 0)),
        ("J", (2, 3, 0, 0, 0, 0)),
        ("F1", (1, 0, 1, 0, 0, 0)),
        ("F2", (4, 0, 0, 0, QUARTER, 0)),
        ("F3", (2, 3, 3, 0, QUARTER, 0)),
        ("F4", (6, 3, 3, 0, 0, 0)),
    ],
)
def test_poses_are_relative_to_links_joints_and_frames(tmp_path: Path, name: str, expected: tuple[float, ...]) -> None:
    found, _ = scope(tmp_path, RELATIVE_TO_JOINT)
    assert expected == place(found, name)


def test_without_relative_to_a_frame_is_relative_to_its_attached_to(tmp_path: Path) -> None:
    frames = "".join(
        f'<frame name="{name}" attached_to="{attached}">{content}</frame>'
        for name, attached, content in (
            ("F0", "", pose(0, 1)),
            ("F1", "L", pose(0, 0, 1)),
            ("F2", "L", pose(0, 0, 2, relative_to="")),
            ("F3", "", pose(0, 0, 3, relative_to="L")),
            ("F4", "F3", ""),
        )
    )
    found, _ = scope(tmp_path, document(model(link("L", pose(1)) + frames), "1.7"))
    expected = {"F0": (0, 1, 0), "F1": (1, 0, 1), "F2": (1, 0, 2), "F3": (1, 0, 3), "F4": (1, 0, 3)}
    for name, position in expected.items():
        assert (*position, 0, 0, 0) == place(found, name)


def test_a_joint_lies_in_its_child_and_a_link_may_lie_in_a_joint(tmp_path: Path) -> None:
    content = link("P") + joint("J", "P", "C", pose(0, 0, 1, relative_to="P")) + link("C", pose(0, 2, relative_to="J"))
    found, _ = scope(tmp_path, document(model(content)))
    assert place(found, "J") == (0, 0, 1, 0, 0, 0)
    assert place(found, "C") == (0, 2, 1, 0, 0, 0)


def test_models_in_models_are_scopes_of_their_own(tmp_path: Path) -> None:
    nested = [model(pose(1, 0, 0, 0, QUARTER) + link("L"), "M1"), model(pose(2) + link("L"), "M2")]
    nested += [model(pose(3, relative_to="M1") + link("L", pose(0, 1)), "M3")]
    found, _ = scope(tmp_path, document(model(link("L") + "".join(nested)), "1.7"))
    assert place(found, "M1::L") == (1, 0, 0, 0, QUARTER, 0)
    assert place(found, "M2::__model__") == (2, 0, 0, 0, 0, 0)
    assert place(found, "M3") == (1, 0, -3, 0, QUARTER, 0)
    assert place(found, "M3::L") == (1, 1, -3, 0, QUARTER, 0)
    assert frame(found, "M3::L").full_name == "M3::L"


PLACED = [
    ("L4", link("L4", pose(0, 0, 1)), "L4"),
    ("__model__", link("L4", pose(0, 0, 1)), "__model__"),
    ("nested", link("L4") + model(link("L", pose(0, 0, 1)), "nested"), "nested"),
    ("F2", f'<frame name="F1">{pose(0, 0, 0, QUARTER)}</frame><frame name="F2">'
           f'{pose(0, 0, 0, 0, QUARTER / 2, relative_to="F1")}</frame>' + link("L1", pose(relative_to="F1")), "F2"),
    ("J2", link("L2", pose(1)) + link("L3", pose(0, 1, relative_to="L2")) + joint("J2", "L2", "L3", pose(0, 0, 1)), "J2"),
]  # fmt: skip


@pytest.mark.parametrize(("attribute", "content", "name"), PLACED, ids=[each[0] for each in PLACED])
def test_a_placement_frame_lies_where_its_model_is_posed(
    tmp_path: Path, attribute: str, content: str, name: str
) -> None:
    placed = model(pose(0, 10, 0, QUARTER) + content, "m", f' placement_frame="{attribute}"')
    found, _ = scope(tmp_path, document(f'<world name="w">{placed}</world>'))
    assert place(found.models["m"], name) == (0, 10, 0, QUARTER, 0, 0)


def test_a_placement_frame_and_relative_to_go_together(tmp_path: Path) -> None:
    base = f'<frame name="base">{pose(-1, 10, 0, QUARTER)}</frame>'
    placed = model(pose(1, relative_to="base") + link("L4", pose(0, 0, 1)), "m", ' placement_frame="L4"')
    found, _ = scope(tmp_path, document(f'<world name="w">{base}{placed}</world>'))
    assert place(found.models["m"], "L4") == (0, 10, 0, QUARTER, 0, 0)
    assert place(found.models["m"], "__model__") == (0, 11, 0, QUARTER, 0, 0)


ATTACHED = document(
    model(
        link("L")
        + model(
            link("L")
            + model(link("L"), "M2")
            + '<frame name="F" attached_to="M2"/>'
            + joint("J1", "L", "F"),
            "M1",
        )
        + "".join(
            f'<frame name="F{number}" attached_to="{name}"/>'
            for number, name in enumerate(("M1", "M1::L", "F1", "M1::F", "M1::J1", ""))
        )
    ),
    "1.8",
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("F0", "M1::L"),
        ("F1", "M1::L"),
        ("F2", "M1::L"),
        ("F3", "M1::M2::L"),
        ("F4", "M1::M2::L"),
        ("F5", "L"),
        ("M1::F", "M1::M2::L"),
        ("__model__", "L"),
    ],
)
def test_every_frame_is_attached_to_a_link(tmp_path: Path, name: str, expected: str) -> None:
    found, _ = scope(tmp_path, ATTACHED)
    assert frame(found, name).link().full_name == expected


def test_the_canonical_link_is_the_first_or_the_named_one(tmp_path: Path) -> None:
    content = model(link("A"), "inner") + link("B") + link("C")
    for more, expected in (("", "B"), (' canonical_link="C"', "C"), (' canonical_link="inner::A"', "inner::A")):
        found, _ = scope(tmp_path, document(model(content, more=more)))
        assert found.frame.link().full_name == expected


@pytest.mark.parametrize(
    "content",
    [
        link("A", pose(relative_to="A")),
        link("A", pose(relative_to="B")) + link("B", pose(relative_to="A")),
        link("P") + link("A", pose(relative_to="J")) + joint("J", "P", "A", pose(relative_to="A")),
        '<frame name="A" attached_to="B"/><frame name="B" attached_to="A"/>',
    ],
)
def test_a_circle_of_frames_is_an_error(tmp_path: Path, content: str) -> None:
    found, _ = scope(tmp_path, document(model(content)))
    with pytest.raises(SdfError, match="form a cycle"):
        frame(found, "A").place  # noqa: B018


def test_a_circle_of_attachments_is_an_error(tmp_path: Path) -> None:
    content = link("L") + f'<frame name="A" attached_to="A">{pose(relative_to="L")}</frame>'
    found, _ = scope(tmp_path, document(model(content)))
    with pytest.raises(SdfError, match="is attached to no link"):
        frame(found, "A").link()


def test_a_frame_that_does_not_exist_is_an_error_with_a_similar_name(tmp_path: Path) -> None:
    found, _ = scope(tmp_path, document(model(link("chassis") + link("L", pose(relative_to="chasis")))))
    with pytest.raises(SdfError, match="model 'm' has no frame 'chasis'") as error:
        frame(found, "L").place  # noqa: B018
    assert error.value.help == ("did you mean 'chassis'?",)


def test_before_1_7_a_pose_names_its_frame_by_frame(tmp_path: Path) -> None:
    content = link("A", pose(1)) + '<link name="B"><pose frame="A">2 0 0 0 0 0</pose></link>'
    for version, x in (("1.6", 3.0), ("1.9", 2.0)):
        found, _ = scope(tmp_path, document(model(content), version))
        assert (x, 0, 0, 0, 0, 0) == place(found, "B")


def test_before_1_7_a_link_and_a_joint_may_share_a_name(tmp_path: Path) -> None:
    content = link("P") + link("wheel", pose(1)) + joint("wheel", "P", "wheel", pose(0, 5))
    found, _ = scope(tmp_path, document(model(content), "1.6"))
    assert frame(found, "wheel").kind == "link"
    assert six(found.joints["wheel"].place)[:2] == (1.0, 5.0)


@pytest.mark.parametrize(
    "text",
    [
        "<pose degrees='true'>1 2 3 90 0 0</pose>",
        "<pose rotation_format='quat_xyzw'>1 2 3 0.7071067811865476 0 0 0.7071067811865476</pose>",
    ],
)
def test_rotations_are_also_degrees_and_quaternions(tmp_path: Path, text: str) -> None:
    found, _ = scope(tmp_path, document(model(link("A", text))))
    assert place(found, "A") == (1, 2, 3, QUARTER, 0, 0)


ANGLE = st.one_of(st.floats(-3.1, 3.1), st.sampled_from([0.0, QUARTER, -QUARTER, QUARTER - 1e-9, math.pi]))


@given(ANGLE, ANGLE, ANGLE)
def test_from_rpy_of_to_rpy_returns_the_same_rotation(roll: float, pitch: float, yaw: float) -> None:
    rotation = from_rpy(roll, pitch, yaw)
    x, y, z, w = rotation
    apart = multiply(from_rpy(*to_rpy(rotation)), (-x, -y, -z, w))
    assert apart[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-14)


def test_the_pose_of_a_long_chain_of_frames_is_computed(tmp_path: Path) -> None:
    frames = "".join(
        f'<frame name="F{number}">{pose(1, relative_to=f"F{number + 1}")}</frame>' for number in range(3000)
    )
    found, _ = scope(tmp_path, document(model(link("L") + frames + '<frame name="F3000"/>')))
    assert frame(found, "F0").place[0] == (3000.0, 0.0, 0.0)
