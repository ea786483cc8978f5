"""Cases of DifferentialController."""

from __future__ import annotations

import json
from typing import Any

import pytest

from graphengine.nodes.wheeled_robots.differential import DifferentialController
from graphengine.testing import RecordingWorld
from tests.nodes.harness import Player
from tests.nodes.isaac.book import Case, differs, made, runs

WHEELS = "isaacsim.robot.wheeled_robots.DifferentialController"
CLASS = "DifferentialController (python class)"


@runs(
    WHEELS,
    "basic",
    "only maxAcceleration set (no maxDeceleration): linear NOT limited, dt still required",
    "clamping (dd100 tutorial params)",
    "tutorial cmd_vel 1.0/1.0",
)
def wheel_speeds_are_those_of_the_case(case: Case, play: Player) -> None:
    node = made(DifferentialController, case)
    node.compute()
    expected = case["expect"]["outputs:velocityCommand"]
    assert node.velocity_command.tolist() == pytest.approx(expected, abs=case["tolerance"], rel=0.0)


@runs(WHEELS, "accel limits ramp")
def after_four_updates_the_ramp_is_not_through(case: Case, play: Player) -> None:
    node = made(DifferentialController, case)
    for _ in range(4):
        node.compute()
    left, right = node.velocity_command.tolist()
    assert 0.0 < left < case["expect"]["outputs:velocityCommand[0]"]["lt"]
    assert 0.0 < right < case["expect"]["outputs:velocityCommand[1]"]["lt"]


@runs(CLASS, "class basic", "class max wheel speed")
def the_nodes_wheel_speeds_are_those_of_the_class(case: Case, play: Player) -> None:
    given = case["inputs"]
    node = DifferentialController(
        wheel_radius=given["wheel_radius"],
        wheel_distance=given["wheel_base"],
        max_wheel_speed=float(given.get("max_wheel_speed", 0.0)),
        linear_velocity=given["command"][0],
        angular_velocity=given["command"][1],
    )
    node.compute()
    assert node.velocity_command.tolist() == case["expect"]["result"]


@differs(WHEELS, "dt<=0 with any accel limit -> compute fails")
def a_ramp_without_dt(case: Case, play: Player) -> Any:
    node = made(DifferentialController, case)
    before = node.velocity_command
    with pytest.raises(ValueError, match=r"dt, .* must be above 0") as caught:
        node.compute()
    return {
        "compute": ValueError.__name__ if issubclass(caught.type, ValueError) else caught.type.__name__,
        "velocityCommand": "unchanged" if node.velocity_command is before else "changed",
    }


@differs(WHEELS, "play-stop-play with jetbot: wheels at rest afterwards")
def wheel_targets_of_the_second_play(case: Case, play: Player) -> Any:
    world = RecordingWorld()
    robot = world.add_robot("/jetbot", ["left", "right"])
    inputs = {
        name: case["inputs"][name] for name in ("wheelRadius", "wheelDistance", "linearVelocity", "angularVelocity")
    }
    playing = play.graph(
        f"""
        nodes:
          Tick: OnPlaybackTick
          Diff: {{type: DifferentialController, inputs: {json.dumps(inputs)}}}
          Art: {{type: ArticulationController, inputs: {{targetPrim: /jetbot}}}}
        connections: [Tick.tick -> Diff.execIn, Tick.tick -> Art.execIn, Diff.velocityCommand -> Art.velocityCommand]
        """,
        world,
    ).tick(10)
    playing.session.stop()
    playing.tick(120)
    return robot.targets["velocity"]
