"""Physics materials: PhysX's rules, resolved against the floor."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.descriptions.engine import mujoco
from graphengine.format.robot_spec import MaterialSpec
from graphengine.physics.model.materials import against_floor, combine, sentences, stronger
from graphengine.physics.simulation import Simulation
from tests.physics.harness import FLOOR, Project

RULES = ("average", "min", "multiply", "max")  # PhysX's order: the later one wins
Frictions = st.floats(0, 2, allow_subnormal=False)


def collider(project: Project) -> mujoco._structs._MjModelGeomViews:
    model = project.load().simulation.model
    return model.geom(int(model.body("bot/base_link").geomadr[0]))


def bound(project: Project, material: str) -> Project:
    return project.robot(f"materials: {{Rubber: {{{material}, bind: [base_link]}}}}")


@pytest.mark.parametrize(
    ("rule", "friction", "words"),
    [
        ("average", 0.5, "the average of its dynamic 0.2 and the floor's 0.8"),
        ("min", 0.2, "the lesser of its dynamic 0.2 and the floor's 0.8"),
        ("multiply", 0.16, "the product of its dynamic 0.2 and the floor's 0.8"),
        ("max", 0.8, "the greater of its dynamic 0.2 and the floor's 0.8: the material's value has no effect"),
    ],
)
def test_a_material_is_mixed_with_the_floor_as_physx_would(
    project: Project, rule: str, friction: float, words: str
) -> None:
    bound(project, f"static_friction: 0.3, dynamic_friction: 0.2, combine: {rule}")
    geom = collider(project)
    assert geom.friction[0] == pytest.approx(friction)
    assert (geom.condim[0], geom.priority[0]) == (3, 1)
    (note,) = project.try_load()[1].items
    assert note.message == f"material 'Rubber': friction {friction:g} on the floor, {words}"
    assert note.help == ("without effect, because MuJoCo does not support it: static friction (0.3)",)


def test_physx_default_is_the_average(project: Project) -> None:
    assert collider(bound(project, "dynamic_friction: 0.2")).friction[0] == pytest.approx((0.2 + 0.8) / 2)


def test_the_friction_of_the_floor_is_the_worlds(project: Project) -> None:
    project.write("world.xml", FLOOR.replace('friction="0.8"', 'friction="0.1"'))
    assert collider(bound(project, "dynamic_friction: 0.2")).friction[0] == pytest.approx(0.15)


@pytest.mark.parametrize(
    "material", ["static_friction: 0, dynamic_friction: 0, combine: multiply", "dynamic_friction: 0, combine: min"]
)
def test_a_contact_without_friction_wins_over_every_other(project: Project, material: str) -> None:
    geom = collider(bound(project, material))
    assert (geom.condim[0], geom.priority[0]) == (1, 2)


MIXED = "its 1 and the floor's 0.8"


@pytest.mark.parametrize(
    ("material", "messages"),
    [
        ("static_friction: 1, dynamic_friction: 1, combine: max", []),
        ("dynamic_friction: 0, combine: min", []),
        (
            "dynamic_friction: 0, combine: multiply",
            ["material 'Rubber': no friction on the floor, the product of its dynamic 0 and the floor's 0.8"],
        ),
        ("static_friction: 0.8, dynamic_friction: 0.8, combine: max", []),
        (
            "static_friction: 1, dynamic_friction: 1, combine: min",
            [
                f"material 'Rubber': friction 0.8 on the floor, the lesser of {MIXED}: the material's value has no effect"
            ],
        ),
        (
            "static_friction: 1, dynamic_friction: 1",
            [f"material 'Rubber': friction 0.9 on the floor, the average of {MIXED}"],
        ),
    ],
)
def test_a_note_on_friction_mentions_only_values_that_the_file_lacks(
    project: Project, material: str, messages: list[str]
) -> None:
    assert [note.message for note in bound(project, material).try_load()[1].items] == messages


def test_properties_without_a_counterpart_are_reported_with_their_numbers() -> None:
    material = MaterialSpec(static_friction=0.9, dynamic_friction=0.6, restitution=0.5)
    _, left_out = sentences("Rubber", material, 0.8)
    assert left_out == "without effect, because MuJoCo does not support it: static friction (0.9), restitution (0.5)"
    assert len(sentences("Plain", MaterialSpec(), 0.8)) == 1


@given(st.sampled_from(RULES), st.sampled_from(RULES))
def test_the_later_of_two_differing_rules_counts(one: str, other: str) -> None:
    assert stronger(one, other) == stronger(other, one) == RULES[max(RULES.index(one), RULES.index(other))]


@given(Frictions, Frictions, st.sampled_from(RULES))
def test_combining_is_symmetric_and_keeps_equals(one: float, other: float, rule: str) -> None:
    mixed = combine(one, other, rule)
    assert mixed == combine(other, one, rule)
    if rule == "multiply":
        assert mixed == one * other
    else:
        assert min(one, other) <= mixed <= max(one, other)


@given(Frictions, Frictions, st.sampled_from(RULES), st.booleans())
def test_only_a_contact_without_friction_has_one_dimension(own: float, floor: float, rule: str, wheel: bool) -> None:
    material = MaterialSpec.model_validate({"dynamic_friction": own, "combine": rule})
    contact = against_floor(material, floor, wheel=wheel)
    assert contact.friction == combine(own, floor, rule)
    assert (contact.condim == 1) == (contact.friction == 0.0)


def test_a_box_slides_down_a_slope_with_the_friction_that_was_resolved(project: Project) -> None:
    # at 30 degrees a friction of 0.3 leaves g (sin 30 - 0.3 cos 30); MuJoCo's own rule, the greater, would leave half of that
    slope = '<geom name="floor" type="plane" size="0 0 1" friction="0.4" euler="0 30 0"/>'
    project.write("world.xml", f"<mujoco><worldbody>{slope}</worldbody></mujoco>")
    placed = "bot: {use: bot.yaml, position: [0, 0, 0.06], orientation: {rpy_deg: [0, 30, 0]}}"
    project.write("scene.yaml", f"scene: t\nworld: world.xml\nrobots:\n  {placed}\n")
    bound(project, "dynamic_friction: 0.2")
    with (project.folder / "bot.yaml").open("a") as file:
        file.write("joints: {arm_joint: {enabled: false, weld: true}}\n")
    world = project.load()
    base = world.simulation.body(world.stage.find("/bot/base_link"))
    speeds = []
    for step in range(240):
        world.simulation.step()
        if step in (119, 239):
            speeds.append(math.hypot(*base.velocity()[0]))
    expected = 9.81 * (math.sin(math.radians(30)) - 0.3 * math.cos(math.radians(30)))
    assert (speeds[1] - speeds[0]) / 0.5 == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("friction", [0.0, 0.7])
def test_a_friction_written_at_run_time_is_mixed_like_a_compiled_one(
    project: Project, rule: str, friction: float
) -> None:
    def told(simulation: Simulation) -> list[list[float]]:
        model = simulation.model
        arrays = (model.geom_friction, model.geom_condim, model.geom_priority, model.geom_solref)
        return [array.tolist() for array in arrays]

    def built_with(dynamic: float) -> Simulation:
        bound(project, f"dynamic_friction: {dynamic}, combine: {rule}")
        return project.load().simulation

    project.write("world.xml", FLOOR.replace('friction="0.8"', 'friction="0.1"'))
    wanted, simulation = told(built_with(friction)), built_with(0.2 if rule == "max" else 0.05)
    built = told(simulation)
    simulation.set_friction(simulation.stage.find("/bot/Materials/Rubber"), (0.5, friction))
    assert told(simulation) == wanted != built
    simulation.reset()
    assert told(simulation) == built


@pytest.mark.parametrize(
    ("value", "told"),
    [
        ("dynamic_friction: -0.1", "dynamic_friction: expected a value ≥ 0, got -0.1"),
        ("static_friction: -1", "static_friction: expected a value ≥ 0, got -1"),
        ("restitution: 1.1", "restitution: expected a value ≤ 1, got 1.1"),
        ("combine: mean", "combine: expected 'average', 'min', 'multiply' or 'max', got 'mean'"),
    ],
)
def test_numbers_that_no_material_has_are_errors(project: Project, value: str, told: str) -> None:
    assert f"error G109: {told}" in bound(project, value).error()
