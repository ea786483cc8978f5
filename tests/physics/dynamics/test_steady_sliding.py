"""Skid-steered wheels whose material has `steady_sliding` move as Coulomb's law says, and stand on slopes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from graphengine.physics.dynamics.directed_friction import _compiled, keep_loads
from graphengine.physics.simulation import Simulation
from tests.other_process import in_another_process
from tests.physics.bases import FOUR, ON_THE_FLOOR, SKID, Base, Floats, four_wheels, joints, reached
from tests.physics.dynamics.coulomb_balance import GRAVITY, balanced, sideslip
from tests.physics.harness import Project, steps

LONG = Base("long", four_wheels(0.6, 0.5), 0.12, 0.08, 30.0)
"""Its wheelbase is longer than its track."""
SIDE_HEAVY = replace(SKID, name="side-heavy", centre=(0.0, -0.085))
TAIL_HEAVY = replace(SKID, name="tail-heavy", centre=(-0.072, 0.0))
"""Their centres of mass lie an eighth of the track or of the wheelbase from the middle, 0.071 m and 0.06 m."""
ARCS = [(0.3, 0.6), (0.5, 0.8), (0.6, -1.0), (1.0, 0.4), (1.0, 1.0), (0.95, 1.5)]
"""Speed (m/s) and turn rate (rad/s), most of them beyond the limits that an import writes."""


def wheels(across: float) -> str:
    """The materials of a robot file whose wheels have the friction 1 along their rolling direction."""
    more = f"across: {across}, direction: [1, 0, 0], expressed_in: base_link, steady_sliding: true, combine: min"
    return f"materials:\n  wheels: {{dynamic_friction: 1.0, {more}, bind: [{', '.join(FOUR)}]}}\n"


def load(project: Project, base: Base, across: float, collider: str = "ellipsoid") -> Simulation:
    project.write("world.xml", '<mujoco><worldbody><geom type="plane" size="0 0 1"/></worldbody></mujoco>')
    for file, text in base.files(wheels(across), 2000.0).items():
        project.write(file, text.replace(": ellipsoid", f": {collider}"))
    project.write("scene.yaml", ON_THE_FLOOR.format(height=base.radius))
    return project.load().simulation


def rims(base: Base, across: float, speed: float, turn: float) -> tuple[float, float]:
    """The speeds of the left and right rims, m/s, with the track of a base that turns on the spot by Coulomb's law."""
    track, length = (2 * abs(getattr(base.wheels[0], axis)) for axis in "yx")
    half = turn * track * (1 + (across * length / track) ** 2) / 2
    return speed - half, speed + half


def drive(simulation: Simulation, base: Base, left: float, right: float, seconds: float = 3.0) -> Floats:
    """The twist that a base reaches, m/s, m/s, rad/s."""
    selected = joints(simulation).select([f"{wheel}_joint" for wheel in FOUR])
    speeds = np.array([left, right, left, right]) / base.radius
    return reached(simulation, lambda share: selected.command(velocities=(share * speeds).tolist()), seconds)


@pytest.mark.parametrize(
    ("base", "seconds"),
    [(SKID, 3.0), (LONG, 3.0), (SIDE_HEAVY, 3.0), (TAIL_HEAVY, 9.0)],  # the last one drifts sideways for longer
    ids=lambda value: value.name if isinstance(value, Base) else "",
)
@pytest.mark.parametrize("across", [0.3, 1.0])
def test_a_skidding_base_moves_on_arcs_as_the_balance_of_coulomb_forces_says(
    project: Project, across: float, base: Base, seconds: float
) -> None:
    simulation = load(project, base, across)
    for speed, turn in ARCS:
        simulation.reset()
        left, right = rims(base, across, speed, turn)
        found, expected = drive(simulation, base, left, right, seconds), balanced(base, 1.0, across, left, right)
        assert math.hypot(*found[:2]) == pytest.approx(math.hypot(*expected[:2]), rel=0.05), (speed, turn)
        assert found[2] == pytest.approx(expected[2], rel=0.05), (speed, turn)
        assert sideslip(found) == pytest.approx(sideslip(expected), abs=math.radians(3.0)), (speed, turn)


@pytest.mark.parametrize(("collider", "places"), [("ellipsoid", (0.0,)), ("as_urdf", (0.5, -0.5))])
def test_ellipsoids_slide_in_the_middle_of_the_wheels_and_cylinders_at_both_rims(
    project: Project, collider: str, places: tuple[float, ...]
) -> None:
    wide = replace(LONG, width=0.2)
    points = tuple(replace(wheel, y=wheel.y + place * wide.width) for wheel in wide.wheels for place in places)
    simulation = load(project, wide, 1.0, collider)
    left, right = rims(wide, 1.0, 0.0, 0.5)
    found, expected = (
        drive(simulation, wide, left, right),
        balanced(replace(wide, wheels=points), 1.0, 1.0, left, right),
    )
    assert found[2] == pytest.approx(expected[2], rel=0.01)


@pytest.mark.parametrize("across", [0.18, 0.3, 1.0])
def test_a_base_that_is_parked_on_a_slope_of_half_its_friction_angle_creeps_by_less_than_a_millimetre_a_second(
    project: Project, across: float
) -> None:
    simulation = load(project, SKID, across)
    slope = min(math.atan(across) / 2, math.radians(10.0))
    for axis in (0, 1):
        simulation.reset()
        simulation.model.opt.gravity[:] = 0.0, 0.0, -GRAVITY * math.cos(slope)
        simulation.model.opt.gravity[axis] = -GRAVITY * math.sin(slope)
        joints(simulation).select([f"{wheel}_joint" for wheel in FOUR]).command(velocities=[0.0] * 4)
        steps(simulation, 240)
        before = simulation.data.qpos[:3].copy()
        steps(simulation, 480)
        assert np.abs(simulation.data.qpos[:3] - before).max() < 2e-3


def test_sliding_wheels_stay_on_the_floor(project: Project) -> None:
    simulation = load(project, SKID, 1.0)
    drive(simulation, SKID, *rims(SKID, 1.0, 0.0, 1.0))
    counts = []
    for _ in range(120):
        steps(simulation, 1)
        counts.append(simulation.data.ncon)
    assert counts == [4] * 120


def path(folder: object) -> bytes:
    simulation = load(Project(folder), SKID, 1.0)  # type: ignore[arg-type]
    return drive(simulation, SKID, *rims(SKID, 1.0, 0.5, 0.8)).tobytes()


def test_a_skidding_base_moves_the_same_in_each_process_and_after_a_reset(project: Project) -> None:
    simulation = load(project, SKID, 1.0)
    command = rims(SKID, 1.0, 0.5, 0.8)
    first = drive(simulation, SKID, *command).tobytes()
    simulation.reset()
    assert drive(simulation, SKID, *command).tobytes() == first
    assert in_another_process(path, project.folder) == first


def test_steady_sliding_needs_a_direction(project: Project) -> None:
    keys = wheels(1.0).replace("across: 1.0, direction: [1, 0, 0], expressed_in: base_link, ", "")
    SKID.write(project, keys)
    project.write("scene.yaml", ON_THE_FLOOR.format(height=SKID.radius))
    assert "`steady_sliding` needs `across` and `direction`" in project.errors()[0]


def test_the_machine_code_keeps_loads_as_python_does_to_the_last_bit() -> None:
    random = np.random.default_rng(3)
    found = []
    count = 40
    geoms = random.integers(0, 4, (count, 2)).astype(np.int32)
    addresses = np.where(random.random(count) < 0.1, -1, 3 * np.arange(count)).astype(np.int32)
    frames, depths = random.normal(size=(count, 9)), random.normal(scale=1e-3, size=count)
    frictions, velocities = random.random((count, 5)), random.normal(size=3 * count)
    solref = np.column_stack([random.choice([0.004, 0.02, -100.0], count), np.ones(count)])
    solimp = np.tile([0.8, 0.95, 0.001, 0.5, 2.0], (count, 1))
    bodies = random.normal(size=(2, 6))
    for keep in (keep_loads, _compiled()[1]):
        positions = np.zeros(3 * count)
        roots = np.array([1, -1])
        values = frames, depths, frictions, solref, solimp, bodies, velocities, positions
        keep(geoms, addresses, *values, np.array([-1, 0, 1, -1]), roots, 1 / 240)
        found.append(positions.tobytes())
        assert np.count_nonzero(positions) > 0
        assert np.all(positions >= 0.0)
    assert found[0] == found[1]
