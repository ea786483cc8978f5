"""ArticulationActuators: feed-forward efforts beside the drives, as the tests of Isaac Sim's node have them."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from graphengine.format.errors import NodeError
from graphengine.nodes.core.actuators import ArticulationActuators
from graphengine.testing import RecordingContext
from tests.nodes import scenes
from tests.nodes.harness import Player, Playing, computed, ready

JOINTS = ["RevoluteJoint", "PrismaticJoint"]
GRAPH = """
    graph: graph
    nodes:
      Tick: OnPlaybackTick
      Control: {type: ArticulationController, inputs: CONTROL}
      Actuators: {type: ArticulationActuators, inputs: ACTUATORS}
      States: {type: ArticulationState, inputs: {targetPrim: /robot}}
    connections: [EXEC Tick.tick -> Control.execIn, Tick.tick -> States.execIn]
    """


def run(
    play: Player,
    stiffness: float,
    damping: float,
    *,
    executed: bool = True,
    drives: dict[str, Any] | None = None,
    control: dict[str, Any] | None = None,
    **inputs: Any,
) -> Playing:
    """An arm of a revolute and a prismatic joint with the node on it, after 120 ticks."""
    files = scenes.arm(JOINTS, stiffness, damping)
    if drives is not None:
        files["robot.yaml"] = json.dumps(json.loads(files["robot.yaml"]) | {"joints": drives})
    given = {"robotPath": "/robot", **inputs}
    text = GRAPH.replace("CONTROL", json.dumps({"targetPrim": "/robot", **(control or {})}))
    text = text.replace("ACTUATORS", json.dumps(given)).replace(
        "EXEC", "Tick.tick -> Actuators.execIn," if executed else ""
    )
    return play.scene(files | {"graph.yaml": text}).tick(120)


@pytest.mark.parametrize("auto", [True, False])
def test_the_drive_brings_the_joint_to_its_target(play: Player, auto: bool) -> None:
    control = {"jointNames": ["RevoluteJoint"], "positionCommand": [0.05]}
    playing = run(play, 100.0, 100.0, control=control, autoStepPrePhysics=auto, stepDt=1 / 60)
    assert playing.node("States").joint_positions[0] == pytest.approx(0.05, abs=0.02)
    assert playing.tick(120).node("States").joint_positions[0] == pytest.approx(0.05, abs=0.01)


def test_a_node_that_is_not_executed_moves_nothing(play: Player) -> None:
    states = run(play, 100.0, 10.0, executed=False, autoStepPrePhysics=False, feedforwardCommand=[100.0]).node("States")
    np.testing.assert_allclose(states.joint_positions, 0.0, atol=0.001)
    np.testing.assert_allclose(states.measured_joint_efforts, 0.0, atol=0.01)


def test_an_effort_acts_in_addition_to_the_drive(play: Player) -> None:
    """A spring of 200 N m/rad that an effort of 7.5 N m bends by 7.5 / 200 rad."""
    states = run(play, 200.0, 40.0, feedforwardCommand=[7.5, 0.0]).node("States")
    np.testing.assert_allclose(states.joint_positions, [7.5 / 200.0, 0.0], atol=1e-3)
    np.testing.assert_allclose(states.measured_joint_efforts, 0.0, atol=0.05)


def test_with_negligible_gains_the_joint_measures_only_the_feed_forward_effort(play: Player) -> None:
    playing = run(play, 0.0, 1e-6, feedforwardCommand=[7.5, 0.0])
    assert playing.node("States").measured_joint_efforts.tolist() == pytest.approx([7.5, 0.0], abs=1e-3)


def test_dof_indices_select_the_joints(play: Player) -> None:
    playing = run(play, 0.0, 1e-6, feedforwardCommand=[5.0], dofIndices=[0])
    assert playing.node("States").measured_joint_efforts.tolist() == pytest.approx([5.0, 0.0], abs=1e-3)


def test_a_joint_without_a_drive_ignores_its_effort(play: Player) -> None:
    driven = {"RevoluteJoint": {"drive": {"damping": 1e-6}}}
    playing = run(play, 0.0, 0.0, drives=driven, feedforwardCommand=[5.0])
    assert playing.node("States").measured_joint_efforts.tolist() == pytest.approx([5.0, 0.0], abs=1e-3)


# Selections, on stubs


def efforts_of(*nodes: dict[str, Any]) -> list[float]:
    """Efforts of three joints after these executions; NaN where none was set."""
    context = RecordingContext()
    robot = context.world.add_robot("/bot", ["a", "b", "c"])
    for inputs in nodes:
        computed(ArticulationActuators, context, robot_path="/bot", **inputs)
    return robot.targets["effort"]


NAN = math.nan


@pytest.mark.parametrize(
    ("executions", "expected"),
    [
        ([{"feedforward_command": [1.0, 2.0, 3.0]}], [1.0, 2.0, 3.0]),
        ([{"feedforward_command": [4.0]}], [4.0, 4.0, 4.0]),
        ([{"feedforward_command": [4.0], "dof_indices": [2, 0]}], [4.0, NAN, 4.0]),
        ([{"feedforward_command": [4.0, 5.0], "dof_indices": [2, 0]}], [5.0, NAN, 4.0]),
        (
            [{"feedforward_command": [1.0, 2.0, 3.0]}, {"feedforward_command": [7.0], "dof_indices": [1]}],
            [1.0, 7.0, 3.0],
        ),
        ([{"feedforward_command": [1.0, 2.0, 3.0]}, {}], [1.0, 2.0, 3.0]),
        ([{"feedforward_command": [4.0], "indices": [0]}], [4.0, 4.0, 4.0]),
    ],
)
def test_efforts_are_set_for_the_selected_joints_and_kept_for_the_others(
    executions: list[dict[str, Any]], expected: list[float]
) -> None:
    np.testing.assert_array_equal(efforts_of(*executions), expected)


@pytest.mark.parametrize(
    ("inputs", "message"),
    [
        ({"feedforward_command": [1.0, 2.0]}, "one effort, or one for each of 3 joints of /bot"),
        ({"feedforward_command": [1.0], "dof_indices": [3]}, "dofIndices cannot be"),
        ({"feedforward_command": [1.0], "dof_indices": [-1]}, "dofIndices cannot be"),
        ({"feedforward_command": [1.0], "indices": [1]}, r"indices must be empty or \[0\]"),
    ],
)
def test_a_wrong_index_or_number_of_efforts_is_refused(inputs: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        efforts_of(inputs)


def test_an_effort_too_large_for_the_physics_is_an_error_of_feedforward_command(play: Player) -> None:
    with pytest.raises(
        NodeError, match=r"feedforwardCommand cannot be .* must be up to 1e\+10 for joint 'RevoluteJoint'"
    ):
        run(play, 0.0, 1e-6, feedforwardCommand=[1e30, 0.0])


def test_a_robot_without_drives_logs_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    context = RecordingContext()
    robot = context.world.add_robot("/bot", ["a"])
    monkeypatch.setattr(type(robot), "set_points", lambda _: (np.array([NAN]), np.array([NAN])))
    ready(ArticulationActuators, context, robot_path="/bot")
    assert context.logged == [("warning", "/bot has no joint with a drive: feedforwardCommand has no effect")]


def test_auto_step_pre_physics_false_logs_that_it_has_no_effect() -> None:
    context = RecordingContext()
    context.world.add_robot("/bot", ["a"])
    ready(ArticulationActuators, context, robot_path="/bot", auto_step_pre_physics=False)
    assert context.logged == [
        ("warning", "autoStepPrePhysics: false has no effect, as drives act in every physics step")
    ]
