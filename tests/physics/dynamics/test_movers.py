"""Movers: their poses, the bodies that they carry, the sensors that see them, and errors. Numbers are from kinematics."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graphengine.devices.entity import Move
from graphengine.devices.stage import Prim
from graphengine.format.errors import ContextError, UsageError
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.occupancy.occupancy_map import MapRequest, make_map
from graphengine.physics.sensors.radar import RayRadar
from graphengine.physics.simulation import Simulation
from tests.physics.dynamics.things import add
from tests.physics.harness import Project, load_with_findings, ticks, yaw_of

FREE = '<body name="{}" pos="{}"><freejoint/><geom type="box" size="{}" mass="2" friction="0.8"/></body>'
RACK = '<body name="rack" pos="0 0 1"><geom type="box" size=".5 2 1"/></body>'
BALL = '<body name="ball" pos="9 0 0.3"><freejoint/><geom size=".1" mass="2"/></body>'
RADAR = {
    "rate": 60.0,
    "angles": (0.0, 0.0, 0.1),
    "elevations": (0.0,),
    "ranges": (0.1, 50.0),
    **dict.fromkeys(("noise_std", "resolution", "velocity_std", "velocity_resolution", "angle_std"), 0.0),
}


@pytest.fixture
def project(project: Project) -> Project:
    """Without a robot."""
    return project.write("scene.yaml", "scene: test\nworld: world.xml\n")


def loaded(project: Project, movers: str, *bodies: str, more: str = "") -> LoadedWorld:
    """A world with movers, each given as `name: {…}` on a line of its own."""
    lines = "".join(f"  {line}\n" for line in movers.splitlines())
    return project.world(*bodies).write("scene.yaml", f"scene: test\nworld: world.xml\n{more}movers:\n{lines}").load()


def place(simulation: Simulation, name: str = "worker") -> tuple[float, float, float, float]:
    """Position and heading of an entity."""
    state = simulation.entities.state(name)
    return (*state.position, yaw_of(state.orientation))


ONCE = "worker: {shape: person, path: [[1, 0], {at: [1, 6], pause: 2s}, [4, 6]], speed: 1.5, start: 1s"
NORTH = math.pi / 2


@pytest.mark.parametrize(
    ("seconds", "loop", "expected"),
    [
        (0.5, "false", (1.0, 0.0, 0.0, NORTH)),
        (3.0, "false", (1.0, 3.0, 0.0, NORTH)),
        (6.0, "false", (1.0, 6.0, 0.0, 0.0)),  # it pauses, and has turned to its next direction
        (8.0, "false", (2.5, 6.0, 0.0, 0.0)),
        (60.0, "false", (4.0, 6.0, 0.0, 0.0)),
        (10.0, "true", (4.0 - 1.5 * 3 / math.sqrt(45), 6.0 - 1.5 * 6 / math.sqrt(45), 0.0, math.atan2(-6, -3))),
        (9.0 + math.sqrt(45) / 1.5 + 1.0, "true", (1.0, 1.5, 0.0, NORTH)),
        (10.0, "there_and_back", (2.5, 6.0, 0.0, math.pi)),
        (12.0, "there_and_back", (1.0, 6.0, 0.0, -NORTH)),
        (15.0, "there_and_back", (1.0, 3.0, 0.0, -NORTH)),
        (18.0, "there_and_back", (1.0, 1.5, 0.0, NORTH)),
    ],
)
def test_a_mover_follows_its_path(project: Project, seconds: float, loop: str, expected: tuple[float, ...]) -> None:
    simulation = loaded(project, f"{ONCE}, loop: {loop}}}").simulation
    ticks(simulation, round(seconds * 60))
    x, y, z, yaw = place(simulation)
    late = simulation.time - seconds  # `seconds` may lie between two ticks
    assert (x, y, z) == pytest.approx(expected[:3], abs=1e-9 + 1.5 * abs(late))
    assert math.remainder(yaw - expected[3], math.tau) == pytest.approx(0.0, abs=1e-9)


def test_a_mover_turns_while_it_walks_on(project: Project) -> None:
    simulation = loaded(
        project, "cart: {shape: box, size: [1, 1, 1], path: [[0, 0], [1, 0], [1, 3]], speed: 1}"
    ).simulation
    ticks(simulation, 75)
    assert place(simulation, "cart") == pytest.approx((1.0, 0.25, 0.0, 0.25 * math.pi))
    assert simulation.entities.state("cart").angular_velocity == pytest.approx((0.0, 0.0, math.pi))


@pytest.mark.parametrize("speed", [0.2, 1.0])
def test_a_moving_platform_carries_a_box_at_its_speed(project: Project, speed: float) -> None:
    lift = f"lift: {{shape: box, size: [2, 2, 0.5], path: [[0, 0, 0], [9, 0, 0]], speed: {speed}}}"
    simulation = loaded(project, lift, FREE.format("load", "0 0 0.551", ".1 .1 .05")).simulation
    ticks(simulation, 60)
    before = place(simulation, "load")[0]
    ticks(simulation, 120)
    assert place(simulation, "load")[0] - before == pytest.approx(2.0 * speed, rel=1e-4)
    assert simulation.entities.state("load").linear_velocity == pytest.approx((speed, 0.0, 0.0), abs=1e-3 * speed)


def test_a_lift_raises_a_box_that_stands_on_it(project: Project) -> None:
    lift = "lift: {shape: box, size: [2, 2, 0.5], path: [[0, 0, 0], [0, 0, 1]], speed: 0.5}"
    simulation = loaded(project, lift, FREE.format("load", "0 0 0.55", ".1 .1 .05")).simulation
    ticks(simulation, 60)
    assert simulation.entities.state("load").linear_velocity[2] == pytest.approx(0.5, rel=0.01)
    ticks(simulation, 120)
    assert place(simulation, "load")[2] == pytest.approx(1.55, abs=1e-3)


def test_a_heavy_load_slows_a_lift_by_less_than_a_thousandth(project: Project) -> None:
    lift = "lift: {shape: box, size: [2, 2, 0.5], path: [[0, 0, 0], [0, 0, 1]], speed: 0.5}"
    simulation = loaded(
        project, lift, FREE.format("load", "0 0 0.55", ".1 .1 .05").replace('mass="2"', 'mass="2000"')
    ).simulation
    ticks(simulation, 100)
    assert simulation.entities.state("lift").linear_velocity[2] == pytest.approx(0.5, rel=1e-3)
    assert place(simulation, "lift")[2] == pytest.approx(0.5 * 100 / 60, abs=1e-6)


def test_a_mover_passes_through_walls_and_pushes_crates(project: Project) -> None:
    truck = "truck: {shape: forklift, path: [[-5, 0], [5, 0]], speed: 1}"
    simulation = loaded(project, truck, RACK, FREE.format("crate", "3 0 0.2", ".2 .2 .2")).simulation
    ticks(simulation, 700)
    assert place(simulation, "truck")[:3] == pytest.approx((5.0, 0.0, 0.0), abs=1e-6)
    assert place(simulation, "crate")[0] > 5.4


def test_a_mover_keeps_to_its_route_against_a_body_that_cannot_give_way(project: Project) -> None:
    cart = "cart: {shape: box, size: [1, 1, 1], path: [[0, 0], [4, 0]], speed: 1}"
    joint = '<joint type="slide" axis="1 0 0" range="0 .001" limited="true"/>'
    gate = f'<body name="gate" pos="2 0 .5">{joint}<geom type="box" size=".1 1 .5" mass="50"/></body>'
    simulation = loaded(project, cart, gate).simulation
    errors: list[float] = []
    ticks(simulation, 270, lambda: errors.append(place(simulation, "cart")[0] - min(simulation.time, 4.0)))
    assert np.abs(errors).max() < 1e-6


def test_bodies_that_no_mover_touches_move_as_in_a_scene_without_movers(project: Project) -> None:
    crate = FREE.format("crate", "4 -3 0.5", ".2 .2 .2").replace(
        "<freejoint/>", '<freejoint/><geom size=".3" pos=".1 0 .2"/>'
    )
    crowd = loaded(project, CROWD, RACK, BALL, crate).simulation
    project.write("scene.yaml", "scene: test\nworld: world.xml\n")
    alone = project.load().simulation
    for simulation in (crowd, alone):
        ticks(simulation, 90)
    for name in ("ball", "crate"):
        assert crowd.entities.state(name) == alone.entities.state(name)


def test_a_mover_pushes_bodies_that_stand_in_its_way_or_lean_against_it(project: Project) -> None:
    cart = "cart: {shape: box, size: [1, 1, 1], path: [[0, 0], [9, 0]], speed: 0.5}"
    pole = '<body name="pole" pos=".85 0 .85" euler="0 -20 0"><freejoint/><geom type="box" size=".05 .3 .9" mass="3"/></body>'
    simulation = loaded(project, cart, pole, FREE.format("crate", "2 0 0.2", ".2 .2 .2")).simulation
    ticks(simulation, 360)
    before = [place(simulation, name)[0] for name in ("pole", "crate")]
    ticks(simulation, 120)
    after = [place(simulation, name)[0] for name in ("pole", "crate")]
    assert np.subtract(after, before) == pytest.approx([1.0, 1.0], rel=0.02)


def test_a_box_between_a_mover_and_a_wall_does_not_blow_up(project: Project) -> None:
    truck = "truck: {shape: forklift, path: [[-5, 0], [5, 0]], speed: 1}"
    simulation = loaded(project, truck, RACK, FREE.format("crate", "-1.5 0 0.2", ".2 .2 .2")).simulation
    ticks(simulation, 600)
    assert np.isfinite(simulation.data.qpos).all()
    assert place(simulation, "truck")[:3] == pytest.approx((5.0, 0.0, 0.0))


def test_a_radar_sees_distance_and_speed_of_a_mover(project: Project) -> None:
    simulation = loaded(project, "cart: {shape: box, size: [2, 2, 2], path: [[9, 0], [2, 0]], speed: 1.2}").simulation
    prim = simulation.stage.add("/Radar", "radar", position=(0.0, 0.0, 1.0), facts=RADAR)
    radar = simulation.device(RayRadar, prim)
    ticks(simulation, 120)
    sample = radar.detections()
    assert sample.points[0] == pytest.approx((9.0 - 1.0 - 2.4, 0.0, 0.0), abs=1e-6)
    assert sample.radial_velocities[0] == pytest.approx(-1.2, abs=1e-6)


CROWD = """one: {shape: person, path: [[2, 0], [2, 3]], speed: 1.3, loop: there_and_back}
two: {shape: person, region: [[-4, -4], [4, 4]], speed: 1.1}
three: {shape: forklift, path: [[-5, 0], [-5, 4], {at: [-6, 4], pause: 500ms}], speed: 1.7, loop: true}"""


def test_the_poses_of_movers_depend_only_on_time_and_seed(project: Project) -> None:
    world = loaded(project, CROWD, RACK, BALL)
    simulation, start = world.simulation, world.simulation.data.qpos.copy()
    ticks(simulation, 200)
    saved, then = simulation.save(), simulation.data.qpos.copy()
    ticks(simulation, 100)
    later = simulation.data.qpos.copy()
    simulation.restore(saved)
    assert simulation.data.qpos.tobytes() == then.tobytes()
    ticks(simulation, 100)
    assert simulation.data.qpos.tobytes() == later.tobytes()
    simulation.reset()
    assert simulation.data.qpos.tobytes() == start.tobytes()
    ticks(simulation, 200)
    assert simulation.data.qpos.tobytes() == then.tobytes()


def test_random_walks_depend_on_the_seed_in_copies_too(project: Project) -> None:
    simulation = loaded(project, CROWD, RACK, BALL).simulation
    same, other = simulation.copy(0), simulation.copy(1)
    for one in (simulation, same, other):
        ticks(one, 300)
    assert place(same, "two") == place(simulation, "two") != place(other, "two")
    assert place(other, "one") == place(simulation, "one")


def test_a_random_walk_stays_in_its_region_and_clear_of_fixed_bodies(project: Project) -> None:
    simulation = loaded(project, "two: {shape: person, region: [[-3, -4], [3, 4]], speed: 2}", RACK).simulation
    walk: list[tuple[float, float]] = []
    ticks(simulation, 3600, lambda: walk.append(place(simulation, "two")[:2]))
    x, y = np.abs(walk).T
    assert x.max() <= 3.0
    assert y.max() <= 4.0
    gap = np.hypot(np.maximum(x - 0.5, 0.0), np.maximum(y - 2.0, 0.0)) - 0.18  # the person's radius
    assert gap.min() > 0.05
    assert np.allclose(np.hypot(*np.diff(walk, axis=0).T).max(), 2.0 / 60.0)


def test_movers_stand_still_while_the_scene_settles(project: Project) -> None:
    world = loaded(project, CROWD, RACK, BALL, more="settle: true\n")
    assert world.simulation.settled_after is not None
    assert place(world.simulation, "one") == pytest.approx((2.0, 0.0, 0.0, NORTH))
    ticks(world.simulation, 60)
    assert place(world.simulation, "one")[:2] == pytest.approx((2.0, 1.3))


def test_a_mover_does_not_push_a_crate_while_the_scene_settles(project: Project) -> None:
    cart = "cart: {shape: box, size: [1, 1, 1], path: [[0, 0], [9, 0]], speed: 2}"
    simulation = loaded(project, cart, FREE.format("crate", "0.9 0 0.21", ".2 .2 .2"), more="settle: true\n").simulation
    assert simulation.settled_after is not None
    assert place(simulation, "crate")[:2] == pytest.approx((0.9, 0.0), abs=1e-6)


def test_a_mover_walks_on_when_a_robot_is_added_or_time_is_reset(project: Project) -> None:
    world = loaded(project, CROWD, RACK, BALL)
    ticks(world.simulation, 30)
    add(world, "late", 9.0)
    assert place(world.simulation, "one")[:2] == pytest.approx((2.0, 0.65))
    ticks(world.simulation, 30)
    assert place(world.simulation, "one")[:2] == pytest.approx((2.0, 1.3))
    world.simulation.reset_state()
    assert place(world.simulation, "one")[:2] == pytest.approx((2.0, 1.3))
    world.simulation.reset_time()
    assert place(world.simulation, "one")[:2] == (2.0, 0.0)


def test_a_mover_is_an_entity_that_cannot_be_moved_or_pushed(project: Project) -> None:
    simulation = loaded(project, CROWD, BALL).simulation
    kinds = {entity.name: entity.kind for entity in simulation.entities.all()}
    assert kinds == {"ball": "object", **dict.fromkeys(("one", "two", "three"), "mover")}
    with pytest.raises(UsageError, match="one cannot be moved: it is a mover, and its path determines its pose"):
        simulation.entities.place("one", Move(position=(0.0, 0.0, 0.0)))
    with pytest.raises(UsageError, match="one cannot be pushed: it is a mover, and its path determines its pose"):
        simulation.entities.push("one", (1.0, 0.0, 0.0), 1.0)
    prim: Prim = simulation.stage.find("/World/one")
    assert simulation.placement(prim) is None
    with pytest.raises(ContextError, match="a joint moves it"):
        simulation.conveyor(prim)


def test_movers_are_not_part_of_a_map(project: Project) -> None:
    request = MapRequest((0.1, 1.5), 0.1, bounds=((-6.0, -6.0), (6.0, 6.0)), seeds=[(4.0, 4.0)])
    with_movers = make_map(loaded(project, CROWD, RACK), request)
    project.write("scene.yaml", "scene: test\nworld: world.xml\n")
    assert np.array_equal(with_movers.cells, make_map(project.load(), request).cells)


def test_a_mesh_can_be_a_mover(project: Project) -> None:
    tent = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
    project.write("meshes/tent.obj", tent)
    simulation = loaded(project, "tent: {shape: meshes/tent.obj, path: [[3, 0], [3, 3]], speed: 1}").simulation
    ticks(simulation, 90)
    box = simulation.entities.bounds("tent")
    assert box is not None
    assert box.low + box.high == pytest.approx((2.0, 1.5, 0.0, 3.0, 2.5, 2.0), abs=1e-6)


def test_a_persons_measures_are_those_of_the_survey(project: Project) -> None:
    simulation = loaded(project, "worker: {shape: person, path: [[0, 0]], speed: 1}").simulation
    box = simulation.entities.bounds("worker")
    assert box is not None
    assert box.low + box.high == pytest.approx((-0.18, -0.18, 0.0, 0.18, 0.18, 1.756), abs=1e-6)


def test_a_warning_names_the_wall_in_which_a_mover_starts(project: Project) -> None:
    project.world(RACK).write(
        "scene.yaml", "scene: test\nworld: world.xml\nmovers:\n  worker: {shape: person, path: [[0.6, 0]], speed: 1}\n"
    )
    _, findings = load_with_findings(project.folder / "scene.yaml")
    (warning,) = findings.warnings
    assert (warning.code, warning.message) == ("W210", "mover 'worker' starts in rack")
    assert warning.span is not None
    assert (warning.span.line, warning.span.column) == (4, 3)


@pytest.mark.parametrize(
    ("mover", "place_of_error", "message"),
    [
        ("shape: persn, path: [[0, 2]], speed: 1", "4:19", "unknown shape 'persn'; did you mean 'person'?"),
        ("shape: person, path: [], speed: 1", "4:3", "the path of a mover needs at least one point"),
        ("shape: person, speed: 1", "4:3", "give either a `path`: [[x, y], …] or a `region`"),
        ("shape: person, path: [[0, .nan]], speed: 1", "4:34", "expected a finite number, got nan"),
        ("shape: person, path: [[0]], speed: 1", "4:34", "a point has 2 or 3 coordinates"),
        ("shape: person, path: [[0, 2]], speed: 0", "4:50", "speed: expected a value > 0, got 0"),
        ("shape: person, path: [[0, 2]], speed: 1, start: 2h", "4:60", "'2h' is not a time"),
        ("shape: person, path: [[0, 2]], speed: 1, loop: back", "4:59", "expected true, false or there_and_back"),
        ("shape: person, path: [[0, 2]], sped: 1", "4:43", "did you mean 'speed'?"),
        ("shape: box, path: [[0, 2]], speed: 1", "4:3", "the shape `box` needs a `size`"),
        ("shape: meshes/none.stl, path: [[0, 2]], speed: 1", "4:19", "no file 'meshes/none.stl'"),
        ("shape: person, region: [[5, 5], [5.001, 5]], speed: 1", "4:35", "finds no free straight way"),
        ("shape: person, region: [[-0.4, -1], [0.4, 1]], speed: 1", "4:35", "finds no free straight way"),
    ],
)
def test_mistakes_have_a_place(project: Project, mover: str, place_of_error: str, message: str) -> None:
    project.world(RACK).write("scene.yaml", f"scene: test\nworld: world.xml\nmovers:\n  worker: {{{mover}}}\n")
    found = "\n".join(project.errors())
    assert message in found
    assert f"scene.yaml:{place_of_error}:" in found


def test_a_mover_cannot_have_the_name_of_a_body(project: Project) -> None:
    project.world(RACK).write(
        "scene.yaml", "scene: test\nworld: world.xml\nmovers:\n  rack: {shape: person, path: [[0, 3]], speed: 1}\n"
    )
    assert "S105: the world already has a body named 'rack'" in project.error()


def test_a_robot_may_have_the_name_of_a_mover(project: Project) -> None:
    robot = "robots:\n  one: {use: bot.yaml, position: [9, 9, 0.1]}\n"
    simulation = loaded(project, CROWD, more=robot).simulation
    assert simulation.entities.state("World/one").position == (2.0, 0.0, 0.0)


def test_texts_of_a_world_in_mjcf_are_not_routes(project: Project) -> None:
    text = '<custom><text name=":mover:rack" data="of somebody else"/></custom>'
    project.world(RACK, before=text)
    assert not project.load().simulation.movers


def test_a_lap_without_length_is_not_a_motion(project: Project) -> None:
    mover = "worker: {shape: person, path: [[1, 0], [1.000001, 0]], speed: 100, loop: true}"
    simulation = loaded(project, mover).simulation
    ticks(simulation, 60)
    assert place(simulation)[:3] == (1.0, 0.0, 0.0)
    assert simulation.entities.state("worker").linear_velocity == (0.0, 0.0, 0.0)
