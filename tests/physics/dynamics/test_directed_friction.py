"""Friction in two directions: bases that skid, mecanum and omni wheels, and the contacts behind them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco
from graphengine.format.robot_spec import MaterialSpec
from graphengine.format.spec import RobotUse
from graphengine.physics.dynamics.directed_friction import _compiled, turn_contacts
from graphengine.physics.model.materials import sentences
from graphengine.physics.simulation import Simulation
from tests.other_process import in_another_process
from tests.physics.bases import (
    FOUR,
    MECANUM,
    MECANUM_WHEELS,
    ON_THE_FLOOR,
    ROLLERS,
    SKID,
    SKID_WHEELS,
    Base,
    Wheel,
    joints,
    material,
    reached,
)
from tests.physics.harness import Project, steps

Floats = NDArray[np.float64]
TWISTS = [(0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, -0.5, 0.0), (0.35, 0.35, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]


def load(project: Project, base: Base, keys: str, damping: float = 50.0) -> Simulation:
    project.write("scene.yaml", ON_THE_FLOOR.format(height=base.radius))
    return base.write(project, keys, damping).load().simulation


def drive(simulation: Simulation, speeds: Sequence[float], robot: str = "bot") -> Floats:
    """The twist that the four wheels' speeds lead to."""
    wheels = joints(simulation, robot).select([f"{name}_joint" for name in FOUR])
    return reached(
        simulation, lambda share: wheels.command(velocities=[share * speed for speed in speeds]), robot=robot
    )


def skid_speeds(ahead: float, turn: float) -> list[float]:
    return [(ahead + side * turn * 0.5708 / 2) / SKID.radius for side in (-1, 1, -1, 1)]


def mecanum_speeds(ahead: float, left: float, turn: float) -> list[float]:
    """Speeds with which no wheel slips along its roller's axis."""
    arm = (0.3 + 0.4208) / 2
    sides = zip(ROLLERS.values(), (-1, 1, -1, 1), strict=True)
    return [(ahead + sign * left + side * arm * turn) / MECANUM.radius for sign, side in sides]


def test_a_skid_steered_base_turns_as_commanded_if_its_tyres_slide_sideways(project: Project) -> None:
    assert drive(load(project, SKID, ""), skid_speeds(0.0, 1.0))[2] < 0.4
    assert drive(load(project, SKID, SKID_WHEELS), skid_speeds(0.0, 1.0))[2] == pytest.approx(1.0, rel=0.025)
    simulation = load(project, SKID, SKID_WHEELS, damping=2000.0)
    assert drive(simulation, skid_speeds(0.0, 1.0))[2] == pytest.approx(1.0, rel=0.01)
    simulation.reset()
    np.testing.assert_allclose(drive(simulation, skid_speeds(0.5, 0.0)), [0.5, 0.0, 0.0], atol=0.001)


@pytest.mark.parametrize("command", TWISTS)
def test_a_mecanum_base_moves_in_every_direction_as_commanded(
    project: Project, command: tuple[float, float, float]
) -> None:
    found = drive(load(project, MECANUM, MECANUM_WHEELS), mecanum_speeds(*command))
    np.testing.assert_allclose(found, command, atol=0.001 * max(map(abs, command)))


def test_the_greater_friction_may_act_across_the_direction(project: Project) -> None:
    keys = "materials:\n" + "".join(
        f"  {name}: {{dynamic_friction: 0, across: 0.8, direction: [3, {-3 * sign}, 0], bind: [{name}]}}\n"
        for name, sign in ROLLERS.items()
    )
    along = drive(load(project, MECANUM, MECANUM_WHEELS), mecanum_speeds(0.2, 0.3, 0.0))
    across = drive(load(project, MECANUM, keys), mecanum_speeds(0.2, 0.3, 0.0))
    np.testing.assert_allclose(across, along, atol=1e-6)
    np.testing.assert_allclose(across, [0.2, 0.3, 0.0], atol=0.001)


@pytest.mark.parametrize("command", [(0.3, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, 0.0, 1.0)])
def test_three_omni_wheels_move_as_commanded(project: Project, command: tuple[float, float, float]) -> None:
    headings = [math.pi / 2, math.pi / 2 + 2 * math.pi / 3, math.pi / 2 - 2 * math.pi / 3]
    places = [(0.15 * math.cos(angle - math.pi / 2), 0.15 * math.sin(angle - math.pi / 2)) for angle in headings]
    wheels = [Wheel(name, x, y, turn) for name, (x, y), turn in zip("abc", places, headings, strict=True)]
    omni = Base("omni", tuple(wheels), 0.04, 0.03, 5.0)
    # The direction is that in which a wheel rolls, which stands still in the base.
    rolling = {wheel.name: (math.cos(wheel.heading), math.sin(wheel.heading)) for wheel in wheels}
    keys = "materials:\n" + "".join(material([name], (*rolls, 0.0), 0.0) for name, rolls in rolling.items())
    simulation = load(project, omni, keys)
    selected = joints(simulation).select([f"{name}_joint" for name in "abc"])
    rolls, at = np.array(list(rolling.values())), np.array(places)
    paths = np.column_stack([rolls, at[:, 0] * rolls[:, 1] - at[:, 1] * rolls[:, 0]])
    speeds = paths @ command / 0.04
    found = reached(simulation, lambda share: selected.command(velocities=(share * speeds).tolist()))
    np.testing.assert_allclose(found, command, atol=0.002)


def test_a_direction_is_in_the_frame_of_the_wheels_parent_link_unless_the_file_gives_a_frame(project: Project) -> None:
    def after_a_turn(more: str) -> Floats:
        simulation = load(project, SKID, "materials:\n" + material(FOUR, (1, 0, 0), 0.05, more))
        drive(simulation, skid_speeds(0.3, 0.8))
        found: Floats = simulation.data.qpos.copy()
        return found

    assert np.array_equal(after_a_turn(""), after_a_turn(", expressed_in: base_link"))
    assert not np.array_equal(after_a_turn(""), after_a_turn(", expressed_in: front_left"))


def test_equal_friction_in_both_directions_changes_nothing(project: Project) -> None:
    def driven(keys: str) -> bytes:
        simulation = load(
            project, SKID, f"materials:\n  all: {{dynamic_friction: 0.8, {keys}bind: [front_left, rear_left]}}"
        )
        drive(simulation, skid_speeds(0.3, 0.8))
        return bytes(simulation.data.qpos.tobytes())

    assert driven("") == driven("across: 0.8, direction: [1, 0, 0], ")


def mecanum_drive(folder: Path) -> bytes:
    again = load(Project(folder), MECANUM, MECANUM_WHEELS).copy(seed=0)
    return drive(again, mecanum_speeds(0.2, 0.3, 0.4)).tobytes()


def test_a_robot_repeats_its_motion_after_a_reset_and_after_a_checkpoint(project: Project) -> None:
    simulation = load(project, MECANUM, MECANUM_WHEELS)
    first = drive(simulation, mecanum_speeds(0.2, 0.3, 0.4)).tobytes(), simulation.data.qpos.tobytes()
    simulation.reset()
    assert (drive(simulation, mecanum_speeds(0.2, 0.3, 0.4)).tobytes(), simulation.data.qpos.tobytes()) == first
    mark = simulation.save()
    steps(simulation, 50)
    then = simulation.data.qpos.tobytes()
    simulation.restore(mark)
    steps(simulation, 50)
    assert simulation.data.qpos.tobytes() == then
    assert in_another_process(mecanum_drive, project.folder) == first[0]


def test_a_settled_scene_stays_at_rest_after_its_start(project: Project) -> None:
    load(project, MECANUM, MECANUM_WHEELS)
    project.write("scene.yaml", ON_THE_FLOOR.format(height=MECANUM.radius) + "settle: true\n")
    simulation = project.load().simulation
    at_start = simulation.data.contact.friction[:, 1].tolist()
    assert max(at_start) < 1e-4
    simulation.reset()
    assert simulation.data.contact.friction[:, 1].tolist() == at_start


def test_spawned_and_removed_robots_do_not_change_the_motion_of_others(project: Project) -> None:
    speeds = mecanum_speeds(0.1, 0.3, 0.4)
    alone = load(project, MECANUM, MECANUM_WHEELS)
    drive(alone, speeds)
    loaded = project.load()
    wheels = joints(loaded.simulation).select([f"{name}_joint" for name in FOUR])

    def command(share: float) -> None:
        wheels.command(velocities=[share * speed for speed in speeds])
        if loaded.simulation.steps == 100:
            loaded.add("other", RobotUse(use="bot.yaml", position=(0.0, 5.0, MECANUM.radius)))
        if loaded.simulation.steps == 300:
            loaded.remove("other")

    reached(loaded.simulation, command)
    assert np.array_equal(alone.data.qpos, loaded.simulation.data.qpos)


def test_a_spawned_robot_moves_as_commanded(project: Project) -> None:
    loaded = MECANUM.write(project, MECANUM_WHEELS, name="spawned").load()
    loaded.add("spawned", RobotUse(use="spawned.yaml", position=(3.0, 0.0, MECANUM.radius)))
    found = drive(loaded.simulation, mecanum_speeds(0.0, 0.4, 0.0), "spawned")
    np.testing.assert_allclose(found, [0.0, 0.4, 0.0], atol=0.001)


def test_sleeping_bodies_stay_asleep_and_do_not_change_the_motion_of_robots(project: Project) -> None:
    speeds = mecanum_speeds(0.1, 0.3, 0.4)
    alone = load(project, MECANUM, MECANUM_WHEELS)
    drive(alone, speeds)
    crate = '<body name="crate" pos="4 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" mass="2"/></body>'
    project.world(crate, before='<option><flag sleep="enable"/></option>')
    simulation = project.load().simulation
    drive(simulation, speeds)
    assert np.count_nonzero(simulation.data.tree_asleep >= 0) == 1
    assert simulation.data.qpos[7:].tolist() == alone.data.qpos.tolist()


def test_friction_that_a_graph_writes_scales_both_directions(project: Project) -> None:
    simulation = load(project, SKID, SKID_WHEELS)
    prim = simulation.stage.find("/bot/Materials/front_left")

    def pair() -> tuple[float, float]:
        along, across = simulation.data.contact.friction[0, :2].tolist()
        return along, across

    steps(simulation, 10)
    assert pair() == pytest.approx((0.8, 0.05))
    simulation.set_friction(prim, (0.4, 0.4))  # mixed with the floor's 0.8 by the average
    assert pair() == pytest.approx((0.6, 0.6 * 0.05 / 0.8))
    simulation.reset()
    steps(simulation, 10)
    assert pair() == pytest.approx((0.8, 0.05))


def test_a_wheel_that_runs_straight_into_a_wall_grips_it_as_with_friction_in_all_directions(project: Project) -> None:
    def driven(keys: str) -> Floats:
        load(project, SKID, keys)
        simulation = project.world('<geom name="wall" type="box" size=".1 2 1" pos=".6 0 1"/>').load().simulation
        drive(simulation, skid_speeds(0.5, 0.0))
        found: Floats = simulation.data.qpos
        return found

    plain = driven(f"materials:\n  all: {{dynamic_friction: 0.8, bind: [{', '.join(FOUR)}]}}")
    np.testing.assert_allclose(driven(SKID_WHEELS), plain, atol=1e-6)


def test_a_mecanum_base_commanded_into_a_wall_stops_in_front_of_it_and_stays_upright(project: Project) -> None:
    load(project, MECANUM, MECANUM_WHEELS)
    walls = '<geom type="box" size=".1 2 1" pos=".4 0 1"/><geom type="box" size="2 .1 1" pos="0 .45 1"/>'
    simulation = project.world(walls).load().simulation
    for command in ((0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (0.3, 0.3, 0.0)):
        drive(simulation, mecanum_speeds(*command))
        (x, y, z), (a, b, _, _) = simulation.body(simulation.stage.find("/bot/base_link")).pose()
        assert max(x, y) < 0.13
        assert z == pytest.approx(MECANUM.radius, abs=0.01)
        assert max(abs(a), abs(b)) < 0.05


def test_two_touching_wheels_with_directions_have_isotropic_friction(project: Project) -> None:
    load(project, SKID, SKID_WHEELS)
    near = "  other: {{use: bot.yaml, position: [{x}, 0, {z}]}}\n"
    text = ON_THE_FLOOR.format(height=SKID.radius) + near.format(x=0.512 + 2 * SKID.radius - 0.001, z=SKID.radius)
    simulation = project.write("scene.yaml", text).load().simulation
    wheels = {g for g in range(simulation.model.ngeom) if simulation.model.geom_bodyid[g]}
    between = [c for c in simulation.data.contact if wheels.issuperset(c.geom.tolist())]
    assert len(between) == 2
    assert all(contact.friction[0] == contact.friction[1] for contact in between)
    drive(simulation, skid_speeds(0.3, 0.0))
    assert np.isfinite(simulation.data.qpos).all()
    other = simulation.body(simulation.stage.find("/other/base_link")).pose()[0]
    assert other[2] == pytest.approx(SKID.radius, abs=0.05)


def test_both_cones_of_friction_will_do(project: Project) -> None:
    load(project, MECANUM, MECANUM_WHEELS)
    project.world(before='<option cone="pyramidal"/>')
    simulation = project.load().simulation
    assert simulation.model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    np.testing.assert_allclose(drive(simulation, mecanum_speeds(0.0, 0.5, 0.0)), [0.0, 0.5, 0.0], atol=0.005)


def _random_contacts(seed: int) -> tuple[list[Any], list[Any]]:
    random = np.random.default_rng(seed)

    def rotations(count: int) -> Floats:
        return np.linalg.qr(random.normal(size=(count, 3, 3)))[0].reshape(count, 9)

    geoms = random.integers(0, 6, (8, 2)).astype(np.int32)
    frames, frictions = rotations(8), random.random((8, 5))
    frames[:, 6:] = np.cross(frames[:, :3], frames[:, 3:6])
    directions = rotations(4)[:, :3].copy()
    row_of = np.array([0, -1, 1, -1, 2, 3])
    ratios = np.array([0.0, 0.3, 4.0, math.inf])
    return [geoms, frames, frictions], [rotations(3), row_of, np.array([0, 1, 2, 2]), directions, ratios]


@given(st.integers(0, 2**32))
def test_tangents_lie_in_the_contact_plane_and_friction_is_never_greater_than_before(seed: int) -> None:
    (geoms, frames, frictions), (rotations, row_of, bodies, directions, ratios) = _random_contacts(seed)
    before, mixed = frames.copy(), frictions.copy()
    turn_contacts(geoms, frames, frictions, rotations, row_of, bodies, directions, ratios)
    assert np.array_equal(frames[:, :3], before[:, :3])
    for contact, (one, other) in enumerate(row_of[geoms].tolist()):
        if (one < 0) == (other < 0):
            assert np.array_equal(frames[contact], before[contact])
            assert np.array_equal(frictions[contact], mixed[contact])
            continue
        row, frame = max(one, other), frames[contact].reshape(3, 3)
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-9)
        assert np.linalg.det(frame) == pytest.approx(1.0)
        direction = rotations[bodies[row]].reshape(3, 3) @ directions[row]
        least = frame[1] if ratios[row] > 1 else frame[2]
        assert direction @ least == pytest.approx(0.0, abs=1e-9)
        share = min(ratios[row], 1 / ratios[row]) if ratios[row] else 0.0
        assert mixed[contact, 0] == frictions[contact, 0]
        assert share * mixed[contact, 0] - 1e-9 <= max(frictions[contact, 1], 0.0)
        assert frictions[contact, 1] <= max(mixed[contact, 0], 1e-5) * (1 + 1e-12)


@given(st.integers(0, 2**32))
def test_the_machine_code_turns_contacts_as_python_does_to_the_last_bit(seed: int) -> None:
    found = []
    for turn in (turn_contacts, _compiled()[0]):
        contacts, table = _random_contacts(seed)
        turn(*contacts, *table)
        found.append([array.tobytes() for array in contacts])
    assert found[0] == found[1]


def test_a_direction_along_the_normal_leaves_the_contact_as_it_is() -> None:
    frames, frictions = np.eye(3).reshape(1, 9).copy(), np.full((1, 5), 0.7)
    table = np.array([0, -1]), np.array([0]), np.array([[1.0, 0.0, 0.0]]), np.array([0.1])
    assert not turn_contacts(np.array([[0, 1]]), frames, frictions, np.eye(3).reshape(1, 9), *table)
    assert np.array_equal(frames.reshape(3, 3), np.eye(3))
    assert np.all(frictions == 0.7)


def test_both_frictions_are_reported() -> None:
    rolling = MaterialSpec(static_friction=0.8, dynamic_friction=0.8, across=0.05, direction=(1.0, 0.0, 0.0))
    (text,) = sentences("Tyre", rolling, 1.0)
    assert text == (
        "material 'Tyre': friction 0.9 along its direction and 0.05625 across it on the floor, "
        "the average of its 0.8 and the floor's 1"
    )


@pytest.mark.parametrize(
    ("keys", "complaint"),
    [
        ("across: 0.1", "friction in two directions needs both `across` and `direction`"),
        ("direction: [1, 0, 0]", "friction in two directions needs both `across` and `direction`"),
        ("expressed_in: base_link", "`expressed_in` is the frame of `direction`; give a `direction` too"),
        ("across: 0.1, direction: [0, 0, 0]", "a direction cannot be the zero vector; write one such as [1, 0, 0]"),
        ("across: -0.1, direction: [1, 0, 0]", "across: "),
        ("across: 0.1, direction: [1, 0]", "direction"),
        ("across: 0.1, direction: [1, 0, 0], expressed_in: chasis", "the robot has no link 'chasis'"),
        (
            "across: 0.1, direction: [0, 0, 2]",
            "its direction, along the z axis of 'base_link', is perpendicular to a floor",
        ),
    ],
)
def test_a_material_that_cannot_be_is_refused_at_its_place(project: Project, keys: str, complaint: str) -> None:
    error = project.robot(f"materials:\n  Tyre: {{{keys}, bind: [base_link]}}").error()
    assert complaint in error
    assert "bot.yaml:4:" in error
