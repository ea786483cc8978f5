"""What a surface gripper holds, and when it lets go. Forces are those of statics, sequences those of Isaac Sim's tests."""

from __future__ import annotations

import math

import pytest

from graphengine.devices.surface_gripper import SurfaceGripperDevice
from graphengine.format.spec import RobotUse
from graphengine.physics.loaded_world import LoadedWorld
from tests.physics.dynamics.things import add, run
from tests.physics.harness import Project

G = 9.81
GANTRY = """<robot name="gantry"><link name="base_link"/>
  <link name="hand">
    <inertial><mass value="1"/><inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size=".04 .04 .04"/></geometry></collision>
  </link>
  <joint name="lift" type="prismatic">
    <parent link="base_link"/><child link="hand"/><origin xyz="0 0 .13"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1000" velocity="1"/>
  </joint>
</robot>"""
ROBOT = """robot: bot
urdf: bot.urdf
fixed_base: true
joints: {{lift: {{drive: {{stiffness: 20000.0, damping: 600.0, max_velocity: 0.2, max_acceleration: 2.0}}}}}}
sensors:
  cup:
    type: surface_gripper
    parent: hand
    position: [0.0, 0.0, -0.02]
    orientation: {{rpy_deg: [0.0, 90.0, 0.0]}}
    profile: {profile}
"""
BOX = '<body name="box" pos="0 0 .05"><freejoint/><geom type="box" size=".05 .05 .05" mass="1" friction=".5"/></body>'
TOUCHING, ABOVE, HIGH = -0.009, 0.0, 0.3
"""Positions of the joint: the gripper is 0.5 mm above the box, 9.5 mm, and 0.31 m."""


class Bench:
    """A gantry with a gripper above a box of 1 kg that stands on the floor."""

    def __init__(self, project: Project, world: str = BOX, *, before: str = "", **profile: object) -> None:
        figures = {"max_grip_distance": 0.005, "retry_interval": 0.0} | profile
        text = ", ".join(f"{key}: {value}" for key, value in figures.items())
        project.write("bot.urdf", GANTRY).write("bot.yaml", ROBOT.format(profile=f"{{{text}}}")).world(
            world, before=before
        )
        project.write("scene.yaml", "scene: test\nworld: world.xml\nrobots: {bot: {use: bot.yaml}}\n")
        self.loaded: LoadedWorld = project.load()
        self.simulation = self.loaded.simulation
        stage = self.simulation.stage
        self.gripper = self.simulation.device(SurfaceGripperDevice, stage.find("/bot/hand/cup"))
        self.lift = self.simulation.articulation(stage.find("/bot")).select(["lift"])

    def go(self, position: float, seconds: float = 2.0) -> None:
        self.lift.command([position])
        run(self.simulation, seconds)

    def lifted(self) -> Bench:
        """Pick up the box."""
        self.go(TOUCHING)
        self.gripper.close()
        self.go(HIGH, 3.0)
        return self

    def pull(self, x: float, z: float, seconds: float = 0.5) -> None:
        """Pull at the box."""
        self.simulation.entities.push("box", (x, 0.0, z), seconds)
        run(self.simulation, seconds)

    @property
    def height(self) -> float:
        return self.simulation.entities.state("box").position[2]

    @property
    def status(self) -> str:
        return self.gripper.status

    @property
    def holds(self) -> tuple[str, list[str]]:
        return self.status, list(self.gripper.gripped)


CLOSED: tuple[str, list[str]] = ("Closed", ["/World/box"])
OPEN: tuple[str, list[str]] = ("Open", [])


def test_a_gripper_closes_opens_and_closes_again(project: Project) -> None:
    bench = Bench(project)
    bench.go(TOUCHING)
    for _ in range(2):
        bench.gripper.close()
        run(bench.simulation, 1.0)
        assert bench.holds == CLOSED
        bench.gripper.open()
        assert bench.holds == OPEN


def test_a_body_beyond_the_reach_is_not_gripped(project: Project) -> None:
    bench = Bench(project)
    bench.go(ABOVE)
    bench.gripper.close()
    assert bench.status == "Closing"
    run(bench.simulation, 1 / 240)
    assert bench.holds == OPEN
    assert Bench(project, max_grip_distance=0.02).lifted().holds == CLOSED


def test_a_gripper_tries_to_grip_for_its_retry_interval(project: Project) -> None:
    bench = Bench(project, retry_interval=1.0)
    bench.go(ABOVE)
    bench.gripper.close()
    run(bench.simulation, 0.5)
    assert bench.status == "Closing"
    bench.go(TOUCHING, 0.4)
    assert bench.holds == CLOSED
    bench.gripper.open()
    bench.go(ABOVE)
    bench.gripper.close()
    run(bench.simulation, 1.01)
    assert bench.status == "Open"
    bench.go(TOUCHING)
    assert bench.holds == OPEN


def test_a_box_is_lifted_as_it_was_gripped(project: Project) -> None:
    bench = Bench(project).lifted()
    hand = bench.simulation.body(bench.simulation.stage.find("/bot/hand")).pose()[0][2]
    assert bench.height > 0.3
    assert hand - bench.height == pytest.approx(0.0705, abs=2e-4)  # half of both, and the gap
    assert bench.simulation.entities.state("box").orientation == pytest.approx((0, 0, 0, 1), abs=1e-4)
    assert bench.simulation.articulation(bench.simulation.stage.find("/bot")).efforts()[0] == pytest.approx(
        2 * G, rel=1e-3
    )


@pytest.mark.parametrize(("pull", "status"), [(18.0, "Closed"), (22.0, "Open")])
def test_a_pull_beyond_the_coaxial_limit_breaks_the_grip(project: Project, pull: float, status: str) -> None:
    """Its weight of 9.81 N pulls too, so that 30 N are between the two."""
    bench = Bench(project, coaxial_force_limit=30.0).lifted()
    assert bench.status == "Closed"
    bench.pull(0.0, -pull)
    assert bench.status == status
    run(bench.simulation, 2.0)
    assert (bench.height > 0.3) == (status == "Closed")


@pytest.mark.parametrize("strength", [25.0, 60.0])
def test_a_push_towards_the_gripper_breaks_no_grip(project: Project, strength: float) -> None:
    bench = Bench(project, coaxial_force_limit=20.0).lifted()
    bench.pull(0.0, strength)
    assert bench.holds == CLOSED


@pytest.mark.parametrize(("force", "status"), [(4.0, "Closed"), (6.0, "Open")])
def test_a_force_across_beyond_the_shear_limit_breaks_the_grip(project: Project, force: float, status: str) -> None:
    """Isaac Sim's test: a limit of 5 N; a force of 4 N is held."""
    bench = Bench(project, shear_force_limit=5.0).lifted()
    bench.pull(force, 0.0)
    assert bench.status == status


def test_a_grip_that_broke_is_tried_again_for_the_retry_interval(project: Project) -> None:
    bench = Bench(project, coaxial_force_limit=30.0, retry_interval=5.0)
    bench.go(TOUCHING)
    bench.gripper.close()
    run(bench.simulation, 0.2)
    bench.pull(0.0, -100.0, 0.1)  # into the floor, where it is at once in reach again
    run(bench.simulation, 0.2)
    assert bench.holds == CLOSED


def test_several_points_hold_several_bodies_and_share_the_load(project: Project) -> None:
    two = BOX.replace("0 0 .05", "0 .06 .05") + BOX.replace("0 0 .05", "0 -.06 .05").replace("box", "box2", 1)
    points = "[[0.0, 0.02, 0.0], [0.0, -0.02, 0.0]]"
    bench = Bench(project, two, points=points).lifted()
    assert bench.holds == ("Closed", ["/World/box", "/World/box2"])
    assert bench.height > 0.3
    wide = Bench(project, BOX, points=points, coaxial_force_limit=7.0).lifted()
    assert wide.holds == CLOSED  # each carries half of 9.81 N


def test_a_gripper_with_an_empty_point_goes_on_closing(project: Project) -> None:
    bench = Bench(project, points="[[0.0, 0.0, 0.0], [0.0, 0.2, 0.0]]").lifted()
    assert bench.holds == ("Closing", ["/World/box"])
    assert bench.height > 0.3
    bench.gripper.open()
    run(bench.simulation, 1.0)
    assert bench.height == pytest.approx(0.05, abs=1e-3)


def test_a_box_that_sleeps_is_lifted_and_one_that_is_released_falls(project: Project) -> None:
    bench = Bench(project, before='<option><flag sleep="enable"/></option>')
    bench.go(TOUCHING, 5.0)
    assert (bench.simulation.data.tree_asleep >= 0).any()
    bench.lifted()
    assert bench.height > 0.3
    run(bench.simulation, 5.0)
    bench.gripper.open()
    run(bench.simulation, 2.0)
    assert bench.height == pytest.approx(0.05, abs=1e-3)


def test_a_checkpoint_goes_on_bit_by_bit_whatever_happened_since(project: Project) -> None:
    bench = Bench(project, coaxial_force_limit=30.0).lifted()
    saved = bench.simulation.save()
    ends: list[object] = []
    for _ in range(2):
        bench.pull(1.0, -19.0)
        bench.pull(0.0, -22.0)
        run(bench.simulation, 0.5)
        ends.append((bench.simulation.entities.state("box"), bench.holds))
        bench.simulation.reset()
        assert bench.holds == OPEN
        bench.simulation.restore(saved)
        assert bench.holds == CLOSED
    assert ends[0] == ends[1]


def test_a_reset_opens_the_gripper_and_the_same_motion_follows(project: Project) -> None:
    bench = Bench(project)
    ends = []
    for _ in range(2):
        ends.append(bench.lifted().simulation.entities.state("box"))
        bench.simulation.reset()
        assert bench.holds == OPEN
        assert bench.height == 0.05
    assert ends[0] == ends[1]


def test_a_robot_that_comes_and_goes_leaves_the_grip_as_it_is(project: Project) -> None:
    ends = []
    for busy in (False, True):
        bench = Bench(project).lifted()
        if busy:
            add(bench.loaded, "late")
        run(bench.simulation, 0.3)
        if busy:
            bench.loaded.remove("late")
        run(bench.simulation, 0.3)
        ends.append((bench.simulation.entities.state("box"), bench.holds))
    assert ends[0] == ends[1]
    assert ends[0][1] == CLOSED


def test_each_robot_of_a_fleet_grips_with_its_own_gripper(project: Project) -> None:
    bench = Bench(project, BOX + BOX.replace("0 0 .05", "2 0 .05").replace("box", "box2", 1))
    bench.loaded.add("bot2", RobotUse(use="bot.yaml", position=(2.0, 0.0, 0.0)))
    stage = bench.simulation.stage
    other = bench.simulation.device(SurfaceGripperDevice, stage.find("/bot2/hand/cup"))
    bench.simulation.articulation(stage.find("/bot2")).select(["lift"]).command([TOUCHING])
    bench.go(TOUCHING)
    other.close()
    run(bench.simulation, 0.1)
    assert bench.holds == OPEN
    assert (other.status, list(other.gripped)) == ("Closed", ["/World/box2"])
    bench.lifted()
    assert bench.holds == CLOSED
    other.open()
    assert bench.holds == CLOSED


def test_a_robot_that_is_held_can_be_removed(project: Project) -> None:
    bench = Bench(project, "")
    _, _, hand = GANTRY.partition('<link name="hand">')
    link = f'<link name="base_link">{hand.partition("</link>")[0]}</link>'
    project.write("box.urdf", f'<robot name="box">{link}</robot>')
    project.write("box.yaml", "robot: box\nurdf: box.urdf\n")
    bench.loaded.add("crate", RobotUse(use="box.yaml", position=(0.0, 0.0, 0.02)))
    bench.go(-0.067, 3.0)
    bench.gripper.close()
    run(bench.simulation, 0.2)
    assert bench.holds == ("Closed", ["/crate/Geometry/base_link"])
    bench.loaded.remove("crate")
    run(bench.simulation, 0.2)
    assert bench.holds == OPEN


@pytest.mark.parametrize(
    ("profile", "error"),
    [
        ("{max_grip_distance: 0.01, clearance_offset: 0.02}", "clearance_offset must be less than max_grip_distance"),
        ("{coaxial_force_limit: -1.0}", "coaxial_force_limit"),
        ("{points: []}", "points"),
        ("{forward_axis: W}", "forward_axis"),
    ],
)
def test_a_bad_profile_is_an_error_at_its_place(project: Project, profile: str, error: str) -> None:
    project.write("bot.urdf", GANTRY).write("bot.yaml", ROBOT.format(profile=profile))
    assert error in project.error()


def test_the_default_profile_is_a_suction_cup_of_30_mm(project: Project) -> None:
    project.write("bot.urdf", GANTRY).write("bot.yaml", ROBOT.replace("    profile: {profile}\n", "").format())
    facts = project.load().stage.find("/bot/hand/cup").facts
    area = math.pi * 0.015**2
    assert facts["coaxial_force_limit"] == pytest.approx(60_000.0 * area, rel=0.02)
    assert facts["shear_force_limit"] == pytest.approx(facts["coaxial_force_limit"] / 2)
