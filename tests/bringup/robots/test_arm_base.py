"""Which robots an import fixes to the world: arms on nothing that moves."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bringup.robots.arms import beam, joint, limb, robot
from tests.bringup.robots.harness import CASTER, imported, keys, rover

LEGS = limb("l", 3, at="0 .2 0", down=True) + limb("r", 3, at="0 -.2 0", down=True)


@pytest.mark.parametrize("parts", [[limb("j", 6)], [limb("j", 3)], [limb("l", 4, at="0 .2 .3") + limb("r", 4)]])
def test_an_arm_is_fixed_to_the_world_with_a_remark(tmp_path: Path, parts: list[str]) -> None:
    found = imported(tmp_path, robot(*parts))
    assert "fixed_base" in keys(found)
    assert not found.free
    (told,) = [remark for remark in found.draft.guessed if "fixed to the world" in remark.text]
    assert "whose base_link moves, write fixed_base: false" in told.text
    assert told.span is not None


def test_an_arm_that_hangs_from_a_bracket_is_fixed(tmp_path: Path) -> None:
    assert not imported(tmp_path, robot(limb("j", 6, down=True))).free


@pytest.mark.parametrize(
    "description",
    [
        robot(LEGS),
        robot(LEGS, limb("arm", 4)),
        robot(limb("j", 2)),
        robot(),
        rover(CASTER, limb("j", 6)),
        robot(limb("j", 6), limb("front_wheel", 1, at=".3 0 0")),
    ],
)
def test_legs_rollers_and_robots_without_an_arm_are_not_bolted_down(tmp_path: Path, description: str) -> None:
    found = imported(tmp_path, description)
    assert "fixed_base" not in keys(found)
    assert found.free


def test_an_arm_with_a_fixed_root_link_is_not_fixed_again(tmp_path: Path) -> None:
    mount = (
        '<link name="world"/><joint name="bolt" type="fixed"><parent link="world"/><child link="base_link"/></joint>'
    )
    found = imported(tmp_path, robot(mount, limb("j", 6)))
    assert "fixed_base" not in keys(found)
    assert not [remark for remark in found.draft.guessed if "fixed to the world" in remark.text]


def test_a_slide_counts_as_a_joint_of_an_arm(tmp_path: Path) -> None:
    slide = joint("lift", "base_link", "mast", "0 0 .05", "0 0 1", "prismatic", lower=0, upper=0.4)
    assert not imported(tmp_path, robot(beam("mast", 2.0, 0.3), slide, limb("j", 2, base="mast"))).free
