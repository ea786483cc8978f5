"""Both ways to cast rays find what `mj_ray` finds: MuJoCo's own to the last bit, ours to a nanometre."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from graphengine.descriptions.engine import mujoco, sort_geoms
from graphengine.format.errors import UsageError
from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from graphengine.physics.ray_casting.casters import Caster
from graphengine.physics.ray_casting.own_colliders import OwnColliders
from graphengine.physics.ray_casting.rays import RaysChoice, select_rays
from graphengine.physics.simulation import Simulation
from tests.physics.conftest import Ship
from tests.physics.harness import SHIPPED, steps
from tests.physics.ray_casting.casters import either_rays, fan, needs_numba, one_by_one, sphere, turned

FAR = 64.0
SCENES = sorted(str(path.relative_to(SHIPPED)) for path in SHIPPED.glob("**/*.yaml") if "\nrobots:" in path.read_text())
Floats = NDArray[np.float64]
World = tuple[mujoco.MjModel, mujoco.MjData]


def world_of(xml: str) -> World:
    model = mujoco.MjModel.from_xml_string(xml)
    sort_geoms(model)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, data


def caster(world: World, rays: RaysChoice, directions: Floats, tree: int = 0) -> Caster:
    return select_rays(rays, *world).caster(directions, FAR, OwnColliders(*world, tree))


def within_reach(distances: Floats) -> Floats:
    """Distances, with those beyond what the sensor sees as misses."""
    return np.where((distances >= 0) & (distances <= FAR), distances, np.inf)


def assert_agree(world: World, origin: Floats, rays: Floats, found: Floats, expected: Floats) -> None:
    """The same to a nanometre, but for rays that are within a nanoradian of an edge."""
    with np.errstate(invalid="ignore"):
        differ = ~((found == expected) | (np.abs(found - expected) <= 1e-9))
    for ray, distance in zip(rays[differ], found[differ], strict=True):
        beside = ray + 1e-9 * sphere(4, 8)
        near, _ = one_by_one(*world, origin, beside / np.linalg.norm(beside, axis=1)[:, None])
        near = within_reach(near)
        assert np.any((near == distance) | (np.abs(near - distance) <= 1e-6))
    assert differ.mean() < 1e-3


# The scenes that ship


@needs_numba
@pytest.mark.parametrize("name", SCENES)
def test_on_the_scenes_that_ship_both_rays_agree_while_robots_drive_come_and_go(ship: Ship, name: str) -> None:
    loaded, generator = ship(name), np.random.default_rng(11)
    simulation = loaded.simulation
    guest = RobotUse.model_validate({"use": "robots/dd100.yaml", "position": [0.3, 0.1, 0.05]})
    both_agree(simulation, generator)
    for robot in simulation.stage.prims("robot"):
        wheels = simulation.articulation(robot).select()
        wheels.command(velocities=generator.uniform(-20, 20, len(wheels.names)).tolist())
    steps(simulation, 240)
    both_agree(simulation, generator)
    loaded.add("guest", guest)
    steps(simulation, 10)
    both_agree(simulation, generator)
    loaded.remove("guest")
    steps(simulation, 10)
    both_agree(simulation, generator)


def both_agree(simulation: Simulation, generator: np.random.Generator, poses: int = 8) -> None:
    """At random poses in the halls, and where the robots have their sensors, level and tilted."""
    world = simulation.model, simulation.data
    bodies = [simulation.body(robot).body for robot in simulation.stage.prims("robot")]
    own = int(simulation.model.body_rootid[bodies[0]])
    for directions in (fan(360), sphere(10, 36)):
        slow, fast = (caster(world, rays, directions, own) for rays in ("mujoco", "fast"))
        for pose in range(poses):
            origin = generator.uniform([-27.0, -24.0, -0.1], [7.0, 32.0, 7.0])
            if pose % 2:
                origin = simulation.data.xpos[generator.choice(bodies)] + generator.normal((0.0, 0.0, 0.16), 0.03)
            tilt = (0.0, 0.001, 0.3, 3.0)[pose // 2 % 4]
            rotation = turned(generator.normal(0, tilt), generator.normal(0, tilt), generator.uniform(-3, 3))
            expected, found = (within_reach(way.cast(origin, rotation)[0]) for way in (slow, fast))
            assert_agree(world, origin, directions @ rotation.T, found, expected)


def test_mujocos_rays_are_mj_ray_bit_for_bit_with_the_robot_taken_out(ship: Ship) -> None:
    model, data, tree = robot_of(ship("dd100_warehouse.yaml"))
    for directions, rotation in (
        (fan(500), np.eye(3)),
        (fan(500), turned(0.2, -0.1, 1.0)),
        (sphere(10, 40), np.eye(3)),
    ):
        origin = data.xpos[tree] + (0.0, 0.0, 0.16)
        distances, geoms = caster((model, data), "mujoco", directions, tree).cast(origin, rotation)
        expected, expected_geoms = one_by_one(model, data, origin, directions @ rotation.T, tree)
        seen = within_reach(expected)
        assert within_reach(distances).tobytes() == seen.tobytes()
        assert np.array_equal(geoms[np.isfinite(seen)], expected_geoms[np.isfinite(seen)])


def robot_of(loaded: LoadedWorld) -> tuple[mujoco.MjModel, mujoco.MjData, int]:
    """The model, and the root body of its robot."""
    model, data = loaded.simulation.model, loaded.simulation.data
    return model, data, int(model.body_rootid[model.body("dd100/chassis_link").id])


# Shapes

MESHES = """<mesh name="tent" vertex="0 0 0 .9 0 0 0 .9 0 0 0 .9"/>
  <mesh name="gem" vertex=".3 0 0 -.3 0 0 0 .4 0 0 -.4 0 0 0 .5 0 0 -.5"/>"""
SHAPES = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "tent", "gem")


def jumble(generator: np.random.Generator, count: int = 25) -> World:
    """Shapes of all kinds that overlap, every other one on a body that can move; planes, whole and cut off."""

    def words(values: Any) -> str:
        return " ".join(map(str, values))

    bodies = ""
    for index in range(count):
        shape = SHAPES[generator.integers(len(SHAPES))]
        kind = f'type="mesh" mesh="{shape}"' if shape in ("tent", "gem") else f'type="{shape}"'
        size = "" if shape in ("tent", "gem") else f'size="{words(generator.uniform(0.05, 0.8, 3))}"'
        pose = f'pos="{words(generator.uniform(-3, 3, 3))}" quat="{words(generator.normal(size=4))}"'
        bodies += f"<body {pose}>{'<freejoint/>' if index % 2 else ''}<geom {kind} {size}/></body>"
    planes = '<geom type="plane" size="0 0 1" pos="0 0 -4" euler="3 5 0"/>'
    planes += '<geom type="plane" size="2 3 1" pos="0 0 4" euler="170 10 0"/>'
    planes += '<geom type="plane" size="2 0 1" pos="0 4 0" euler="90 10 0"/>'
    return world_of(f"<mujoco><asset>{MESHES}</asset><worldbody>{planes}{bodies}</worldbody></mujoco>")


@needs_numba
@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_rays_hit_every_shape_where_mj_ray_does_from_outside_and_inside(seed: int) -> None:
    generator = np.random.default_rng(seed)
    model, data = world = jumble(generator)
    directions = sphere(8, 20)
    fast = caster(world, "fast", directions)
    outside, inside = generator.uniform(-3.5, 3.5, 3), data.geom_xpos[generator.integers(3, model.ngeom)]
    for origin in (outside, inside.copy()):
        rotation = turned(*generator.uniform(-3, 3, 3))
        found, geoms = fast.cast(origin, rotation)
        expected, expected_geoms = one_by_one(model, data, origin, directions @ rotation.T)
        assert_agree(world, origin, directions @ rotation.T, within_reach(found), within_reach(expected))
        same = np.abs(found - expected) <= 1e-9
        assert (geoms == expected_geoms)[same & (expected >= 0)].mean() > 0.99


@needs_numba
def test_a_height_field_is_met_where_mj_ray_meets_it() -> None:
    model, data = world = world_of(
        """<mujoco><asset><hfield name="hills" nrow="9" ncol="12" size="3 2 1.2 0.3"/></asset>
        <worldbody><geom type="hfield" hfield="hills" pos="0.3 0.2 -0.5" euler="10 20 30"/></worldbody></mujoco>"""
    )
    generator = np.random.default_rng(3)
    model.hfield_data[:] = generator.uniform(0, 1, model.hfield_data.shape)
    directions = sphere(30, 60)
    fast = caster(world, "fast", directions)
    hits = 0
    for origin in (*generator.uniform(-4, 4, (6, 3)), np.array([0.3, 0.2, -0.6])):
        found, _ = fast.cast(origin, np.eye(3))
        expected, _ = one_by_one(model, data, origin, directions)
        assert_agree(world, origin, directions, within_reach(found), within_reach(expected))
        hits += int((expected >= 0).sum())
    assert hits > 1000


@either_rays
def test_a_plane_is_met_from_its_front_and_within_its_rectangle_only(rays: RaysChoice) -> None:
    world = world_of('<mujoco><worldbody><geom type="plane" size="1 2 1" pos="0 0 1"/></worldbody></mujoco>')
    down, up = np.array([[0.0, 0.0, -1.0]]), np.array([[0.0, 0.0, 1.0]])
    for origin, ray, distance in (
        ((0.9, 1.9, 3.0), down, 2.0),
        ((1.1, 0.0, 3.0), down, -1.0),
        ((0.0, 2.1, 3.0), down, -1.0),
        ((0.0, 0.0, 0.0), up, -1.0),
        ((0.0, 0.0, 0.0), down, -1.0),
    ):
        found, _ = caster(world, rays, ray).cast(np.array(origin), np.eye(3))
        assert found.tolist() == [distance]


@either_rays
def test_of_two_surfaces_at_the_same_distance_the_first_in_the_model_is_hit(rays: RaysChoice) -> None:
    box = '<geom type="box" size="1 1 1" pos="3 0 0"/>'
    world = world_of(f"<mujoco><worldbody><body>{box}</body><body><freejoint/>{box}</body></worldbody></mujoco>")
    distances, geoms = caster(world, rays, np.array([[1.0, 0.0, 0.0]])).cast(np.zeros(3), np.eye(3))
    assert (distances.tolist(), geoms.tolist()) == ([2.0], [0])


@either_rays
def test_rays_pass_through_transparent_geoms_and_their_own_robot(rays: RaysChoice) -> None:
    world = world_of(
        """<mujoco><asset><material name="glass" rgba="1 1 1 0"/></asset><worldbody>
          <geom type="box" size=".1 1 1" pos="2 0 0" rgba="1 1 1 0"/>
          <geom type="box" size=".1 1 1" pos="3 0 0" material="glass"/>
          <body name="base" pos="4 0 0"><freejoint/><geom type="box" size=".1 1 1"/>
            <body><joint/><geom type="box" size=".1 1 1" pos="1 0 0"/></body></body>
          <geom type="box" size=".1 1 1" pos="6 0 0"/>
        </worldbody></mujoco>"""
    )
    ahead, base = np.array([[1.0, 0.0, 0.0]]), int(world[0].body("base").id)
    assert caster(world, rays, ahead).cast(np.zeros(3), np.eye(3))[0].tolist() == pytest.approx([3.9])
    assert caster(world, rays, ahead, base).cast(np.zeros(3), np.eye(3))[0].tolist() == pytest.approx([5.9])


@either_rays
def test_surfaces_at_the_maximum_range_are_hit(rays: RaysChoice) -> None:
    world = world_of(f'<mujoco><worldbody><geom type="box" size="1 1 1" pos="{FAR + 1} 0 0"/></worldbody></mujoco>')
    assert caster(world, rays, np.array([[1.0, 0.0, 0.0]])).cast(np.zeros(3), np.eye(3))[0].tolist() == [FAR]


@either_rays
def test_a_world_without_geoms_is_empty(rays: RaysChoice) -> None:
    assert caster(world_of("<mujoco/>"), rays, fan(5)).cast(np.zeros(3), np.eye(3))[0].tolist() == [-1.0] * 5


# What moves


@either_rays
@pytest.mark.parametrize(("joint", "distance"), [("slide", 2.0), ("hinge", 2.5 - 0.5 * math.sqrt(2))])
def test_sliding_and_turning_bodies_are_hit_at_their_present_pose(
    rays: RaysChoice, joint: str, distance: float
) -> None:
    model, data = world = world_of(
        f"""<mujoco><worldbody><body pos="2.5 0 0"><joint type="{joint}" axis="0 {"1 0" if joint == "slide" else "0 1"}"/>
        <geom type="box" size="0.5 0.5 0.5"/></body></worldbody></mujoco>"""
    )
    data.qpos[:] = 3.0 if joint == "slide" else 0.0
    mujoco.mj_forward(model, data)
    seeing = caster(world, rays, np.array([[1.0, 0.0, 0.0]]))
    seeing.cast(np.zeros(3), np.eye(3))
    data.qpos[:] = 0.0 if joint == "slide" else math.pi / 4
    mujoco.mj_forward(model, data)
    assert seeing.cast(np.zeros(3), np.eye(3))[0].tolist() == pytest.approx([distance])


@either_rays
def test_moving_bodies_are_hit_at_their_present_pose(rays: RaysChoice) -> None:
    model, data = world = jumble(np.random.default_rng(5), 60)
    seeing = caster(world, rays, sphere(10, 40))
    generator = np.random.default_rng(6)
    for _ in range(5):
        data.qpos[:] += generator.normal(0, 0.5, model.nq)
        mujoco.mj_forward(model, data)
        found, _ = seeing.cast(np.array([0.1, 0.2, 0.3]), np.eye(3))
        expected, _ = one_by_one(model, data, np.array([0.1, 0.2, 0.3]), sphere(10, 40))
        assert_agree(world, np.array([0.1, 0.2, 0.3]), sphere(10, 40), within_reach(found), within_reach(expected))


@needs_numba
def test_a_scan_does_not_depend_on_hidden_geoms_to_the_last_bit() -> None:
    """Boxes all around hide what is beyond them. With more or less of it, the trees are others and the distances the same."""

    def scene(hidden: int) -> World:
        near = "".join(
            f'<body pos="{x} {y} 0" euler="0 0 {17 * x + 5 * y}"><geom type="box" size=".8 .8 2"/></body>'
            for x in (-2, 0, 2)
            for y in (-2, 0, 2)
            if (x, y) != (0, 0)
        )
        generator = np.random.default_rng(1)
        far = "".join(
            f'<body pos="{9 + x} {y} {z}"><freejoint/><geom size=".3"/></body>'
            for x, y, z in generator.uniform(0, 9, (hidden, 3))
        )
        return world_of(f"<mujoco><worldbody>{near}{far}</worldbody></mujoco>")

    seen = [
        caster(scene(hidden), "fast", fan(1000)).cast(np.array([0.1, 0.2, 0.0]), np.eye(3)) for hidden in (0, 1, 90)
    ]
    near = seen[0][0] < 4
    assert near.mean() > 0.9
    for distances, geoms in seen[1:]:
        assert distances[near].tobytes() == seen[0][0][near].tobytes()
        assert geoms[near].tolist() == seen[0][1][near].tolist()


# Which are used


def test_ours_are_used_where_numba_is_and_mujocos_on_request(ship: Ship) -> None:
    pytest.importorskip("numba")
    simulation = ship("dd100_flat.yaml").simulation
    assert simulation.rays.name == "fast"
    assert select_rays("mujoco", simulation.model, simulation.data).name == "mujoco"


def test_without_numba_mujocos_are_used_and_ours_on_request_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("graphengine.physics.ray_casting.fast")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "numba", None)
    world = world_of("<mujoco/>")
    assert select_rays("auto", *world).name == "mujoco"
    with pytest.raises(UsageError, match=r"need numba.*\n.*pip install '\.\[fast\]'"):
        select_rays("fast", *world)


@pytest.fixture
def fast() -> Iterator[Any]:
    """The module of ours, which does not know yet whether numba works in this process."""
    pytest.importorskip("numba")
    from graphengine.physics.ray_casting.fast import rays

    rays.trouble.cache_clear()
    yield rays
    rays.trouble.cache_clear()


def test_where_numba_may_not_compile_mujocos_are_used(fast: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fast.numba.config, "DISABLE_JIT", 1)
    assert select_rays("auto", *world_of("<mujoco/>")).name == "mujoco"
    with pytest.raises(UsageError, match="NUMBA_DISABLE_JIT keeps numba from compiling them"):
        select_rays("fast", *world_of("<mujoco/>"))


def test_without_numba_mujocos_rays_are_used_with_a_message(
    fast: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(*_: object) -> None:
        raise EOFError("Ran out of input")  # what comes of a file that a crash left empty

    monkeypatch.setattr(fast.FastRays, "__init__", fail)
    assert select_rays("auto", *world_of("<mujoco/>")).name == "mujoco"
    (told,) = caplog.messages
    assert "EOFError: Ran out of input; if numba's cache is damaged, delete its files in /" in told
    with pytest.raises(UsageError, match=r"'fast' cannot be cast here: EOFError: .*\n  use rays 'mujoco' instead"):
        select_rays("fast", *world_of("<mujoco/>"))


def test_a_long_compilation_is_announced(
    fast: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from numba.core.event import trigger_event

    assert fast.trouble() == ""
    caplog.clear()
    fast.trouble.cache_clear()
    assert fast.trouble() == ""
    assert caplog.messages == [], "kernels that are there are not compiled"
    quick = fast.FastRays.__init__

    def compiling(*given: Any) -> None:
        for _ in range(2):
            with trigger_event("numba:compile"):
                quick(*given)

    monkeypatch.setattr(fast.FastRays, "__init__", compiling)
    fast.trouble.cache_clear()
    assert fast.trouble() == ""
    assert caplog.messages == ["compiling the ray casting of lidars, which takes some seconds"]


@needs_numba
def test_after_rays_are_selected_a_cast_compiles_no_kernel() -> None:
    from graphengine.physics.ray_casting.fast import kernel, table, tree

    seeing = caster(jumble(np.random.default_rng(1)), "fast", fan(10))
    kernels: list[Any] = [kernel.cast, table.follow, table.enclose, tree.build]
    before = [len(each.signatures) for each in kernels]
    seeing.cast(np.zeros(3), np.eye(3))
    assert [len(each.signatures) for each in kernels] == before


SDF = f'<asset>{MESHES}</asset><worldbody><geom type="sdf" mesh="gem"/></worldbody>'
LAND = f"""<asset><hfield name="land" nrow="{math.isqrt(500_000) + 1}" ncol="{math.isqrt(500_000) + 1}" size="9 9 1 1"/></asset>
  <worldbody><geom type="hfield" hfield="land"/></worldbody>"""


@needs_numba
@pytest.mark.parametrize(
    ("content", "told"),
    [(SDF, "do not support geoms of type sdf"), (LAND, "more than 1000000 triangles")],
    ids=["a shape that they do not know", "too many triangles"],
)
def test_geoms_that_fast_rays_cannot_hit_leave_the_scene_to_mujocos_rays(content: str, told: str) -> None:
    world = world_of(f"<mujoco>{content}</mujoco>")
    assert select_rays("auto", *world).name == "mujoco"
    with pytest.raises(UsageError, match=told):
        select_rays("fast", *world)


@needs_numba
def test_a_kernel_that_can_be_kept_nowhere_still_runs() -> None:
    from graphengine.physics.kernels.compiled import kernel

    made: dict[str, Any] = {}
    exec("def twice(x):\n    return 2 * x", made)  # a function without a source file
    assert kernel(made["twice"])(21) == 42
