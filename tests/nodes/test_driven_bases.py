"""Controllers of bases that are no plain differential drive, in graphs, against physics."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from graphengine.format.diagnostics import CheckError
from graphengine.physics.simulation import Simulation
from tests.nodes.harness import Player, Playing
from tests.physics.bases import (
    FOUR,
    MECANUM,
    MECANUM_WHEELS,
    ON_THE_FLOOR,
    Base,
    Wheel,
    four_wheels,
    material,
    twist,
)
from tests.physics.harness import FLOOR

Floats = NDArray[np.float64]
WHEELS = ", ".join(f"{name}_joint" for name in FOUR)

HOLONOMIC = f"""graph: drive
nodes:
  Tick: OnPlaybackTick
  Controller:
    type: HolonomicController
    inputs:
      rolling: true
      wheelRadius: [0.05]
      wheelPositions: [[0.15, 0.2104, 0], [0.15, -0.2104, 0], [-0.15, 0.2104, 0], [-0.15, -0.2104, 0]]
      wheelOrientations: [[1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]]
      wheelAxis: [0, 1, 0]
      mecanumAngles: [45, -45, -45, 45]
      inputVelocity: COMMAND
  Wheels: {{type: ArticulationController, inputs: {{targetPrim: /bot, jointNames: [{WHEELS}]}}}}
connections:
  - Tick.tick -> Controller.execIn
  - Tick.tick -> Wheels.execIn
  - Controller.jointVelocityCommand -> Wheels.velocityCommand
"""
READ_FROM_THE_ROBOT = """graph: drive
nodes:
  Tick: OnPlaybackTick
  Setup: {type: HolonomicRobotUsdSetup, inputs: {robotPrim: /bot, comPrim: /bot/base_link}}
  Controller: {type: HolonomicController, inputs: {rolling: true, inputVelocity: COMMAND}}
  Wheels: {type: ArticulationController, inputs: {targetPrim: /bot}}
connections:
  - Tick.tick -> Controller.execIn
  - Setup.wheelRadius -> Controller.wheelRadius
  - Setup.wheelPositions -> Controller.wheelPositions
  - Setup.wheelOrientations -> Controller.wheelOrientations
  - Setup.mecanumAngles -> Controller.mecanumAngles
  - Setup.wheelAxis -> Controller.wheelAxis
  - Setup.upAxis -> Controller.upAxis
  - Tick.tick -> Wheels.execIn
  - Setup.wheelDofNames -> Wheels.jointNames
  - Controller.jointVelocityCommand -> Wheels.velocityCommand
"""
ACKERMANN = """graph: drive
nodes:
  Tick: OnPlaybackTick
  Controller:
    type: AckermannController
    inputs:
      {wheelBase: 0.5, trackWidth: TRACK, frontWheelRadius: 0.1, backWheelRadius: 0.1, speed: 0.5, steeringAngle: ANGLE}
  DrivenWheels: {type: ArraySlice, inputs: {start: FIRST, end: END, useLength: false}}
  SteeredWheels: {type: ArraySlice, inputs: {end: STEERED, useLength: false}}
  SteeringAngles: {type: Multiply, inputs: {a: {type: "double[]", value: SIGNS}}}
  Wheels: {type: ArticulationController, inputs: {targetPrim: /bot, jointNames: DRIVEN_JOINTS}}
  Steering: {type: ArticulationController, inputs: {targetPrim: /bot, jointNames: STEERING_JOINTS}}
connections:
  - Tick.tick -> Controller.execIn
  - Controller.wheelRotationVelocity -> DrivenWheels.array
  - Controller.wheelAngles -> SteeredWheels.array
  - SteeredWheels.array -> SteeringAngles.b
  - Tick.tick -> Wheels.execIn
  - DrivenWheels.array -> Wheels.velocityCommand
  - Tick.tick -> Steering.execIn
  - SteeringAngles.product -> Steering.positionCommand
"""


def start(play: Player, base: Base, keys: str, graph: str) -> Playing:
    files = base.files(keys) | {"world.xml": FLOOR, "graph.yaml": graph}
    files["scene.yaml"] = (
        ON_THE_FLOOR.format(height=base.radius) + "graphs: {drive: {use: graph.yaml, at: /World/drive}}\n"
    )
    return play.scene(files)


def mean_twist(playing: Playing, ticks: int = 180) -> Floats:
    """The twist of the base over the last third of a run."""
    world = playing.session.services.world
    assert isinstance(world, Simulation)
    seen = playing.each_tick(ticks, lambda: twist(world))
    mean: Floats = np.mean(seen[2 * ticks // 3 :], axis=0)
    return mean


every_command = pytest.mark.parametrize(
    "command", [(0.5, 0.0, 0.0), (0.0, 0.3, 0.0), (0.0, -0.3, 0.0), (0.0, 0.0, 0.8), (0.2, 0.3, 0.0)]
)


@every_command
def test_a_mecanum_base_drives_as_commanded_with_the_geometry_read_from_the_robot(
    play: Player, command: Sequence[float]
) -> None:
    playing = start(play, MECANUM, MECANUM_WHEELS, READ_FROM_THE_ROBOT.replace("COMMAND", str(list(command))))
    np.testing.assert_allclose(mean_twist(playing), command, atol=0.01 * max(map(abs, command)))
    setup = playing.node("Setup")
    assert setup.wheel_dof_names == tuple(f"{name}_joint" for name in FOUR)
    np.testing.assert_allclose(setup.wheel_radius, [0.05] * 4)
    np.testing.assert_allclose(setup.mecanum_angles, [45, -45, -45, 45], atol=1e-6)
    places = [(0.15, 0.2104, 0), (0.15, -0.2104, 0), (-0.15, 0.2104, 0), (-0.15, -0.2104, 0)]
    np.testing.assert_allclose(setup.wheel_positions, places, atol=1e-9)
    np.testing.assert_allclose(setup.wheel_orientations, [(1, 0, 0, 0)] * 4, atol=1e-9)
    assert (setup.wheel_axis, setup.up_axis) == ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


THREE = Base(
    "omni",
    tuple(
        Wheel(f"wheel_{number}", 0.15 * math.cos(angle), 0.15 * math.sin(angle), angle - math.pi / 2)
        for number, angle in enumerate((math.pi / 3, math.pi, -math.pi / 3))
    ),
    0.04,
    0.02,
    3.0,
)
"""Three omnidirectional wheels with axles along their radii, as Isaac Sim's Kaya."""
ROLLING = "materials:\n" + "".join(
    material([wheel.name], (math.cos(wheel.heading), math.sin(wheel.heading), 0), 0.0) for wheel in THREE.wheels
)


@pytest.mark.parametrize("command", [(0.2, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.8), (0.1, -0.1, 0.4)])
def test_an_omnidirectional_base_drives_as_commanded_with_the_geometry_read_from_the_robot(
    play: Player, command: Sequence[float]
) -> None:
    playing = start(play, THREE, ROLLING, READ_FROM_THE_ROBOT.replace("COMMAND", str(list(command))))
    np.testing.assert_allclose(mean_twist(playing), command, atol=0.01 * max(map(abs, command)))
    assert np.abs(playing.node("Setup").mecanum_angles).tolist() == pytest.approx([90.0] * 3)


def test_a_base_whose_wheels_have_no_rollers_is_refused_with_a_remedy(play: Player) -> None:
    with pytest.raises(CheckError, match=r"no wheel of /bot has rollers") as caught:
        start(play, MECANUM, "", READ_FROM_THE_ROBOT.replace("COMMAND", "[0, 0, 0]"))
    assert "give the materials of mecanum wheels `direction` and `across`" in str(caught.value)


@every_command
def test_the_holonomic_controller_drives_a_mecanum_base_as_commanded(play: Player, command: Sequence[float]) -> None:
    found = mean_twist(start(play, MECANUM, MECANUM_WHEELS, HOLONOMIC.replace("COMMAND", str(list(command)))))
    np.testing.assert_allclose(found, command, atol=0.01 * max(map(abs, command)))


def car(sign: int) -> Base:
    wheels = [Wheel(w.name, w.x, w.y, steering=sign if w.x > 0 else 0) for w in four_wheels(0.5, 0.4)]
    return Base("car", tuple(wheels), 0.1, 0.05, 8.0, ("rear_left", "rear_right"))


def tricycle(sign: int) -> Base:
    wheels = (
        Wheel("front", 0.25, 0.0, steering=sign),
        Wheel("rear_left", -0.25, 0.2),
        Wheel("rear_right", -0.25, -0.2),
    )
    return Base("tricycle", wheels, 0.1, 0.05, 8.0, ("front",))


FORMS = {
    "four joints": (
        car,
        "0.4",
        "2",
        "4",
        "2",
        "[rear_left_joint, rear_right_joint]",
        "[front_left_steer, front_right_steer]",
    ),
    "bicycle": (tricycle, "0.0", "0", "1", "1", "[front_joint]", "[front_steer]"),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("sign", [1, -1], ids=["axis up", "axis down"])
@pytest.mark.parametrize("angle", [0.4, -0.25])
def test_the_ackermann_controller_drives_the_commanded_radius(play: Player, form: str, sign: int, angle: float) -> None:
    base, track, first, end, steered, driven, steering = FORMS[form]
    graph = ACKERMANN
    for name, text in (
        ("TRACK", track),
        ("ANGLE", str(angle)),
        ("FIRST", first),
        ("END", end),
        ("STEERED", steered),
        ("SIGNS", str([float(sign)] * int(steered))),
        ("DRIVEN_JOINTS", driven),
        ("STEERING_JOINTS", steering),
    ):
        graph = graph.replace(name, text)
    ahead, _, turn = mean_twist(start(play, base(sign), "", graph)).tolist()
    assert ahead == pytest.approx(0.5, rel=0.02)
    assert ahead / turn == pytest.approx(0.5 / math.tan(angle), rel=0.02)
