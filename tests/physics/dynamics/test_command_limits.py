"""What a command may ask of a joint at most: as its description says, and finite where that says nothing."""

from __future__ import annotations

import pytest

from tests.physics.harness import CART, ROBOT, Project

FREE = CART.replace('type="revolute"', 'type="continuous"').replace(
    '<limit lower="-1" upper="1" effort="40" velocity="1"/>', ""
)


@pytest.mark.parametrize(
    ("description", "kind", "beyond"),
    [
        (CART, "efforts", "effort of /bot/arm_joint beyond -40 to 40"),
        (FREE, "efforts", "effort of /bot/arm_joint beyond -58.86 to 58.86"),  # which lifts 6 kg at 1 m
        (CART, "velocities", "velocity of /bot/arm_joint beyond -17453.3 to 17453.3"),
        (CART, "positions", "position of /bot/arm_joint beyond -3 to 3"),
    ],
)
@pytest.mark.parametrize("value", [1e9, -1e9])
def test_what_lies_beyond_it_is_clamped_and_counted(
    project: Project, description: str, kind: str, beyond: str, value: float
) -> None:
    driven = f"{ROBOT}joints: {{arm_joint: {{drive: {{stiffness: 9, damping: 9}}}}}}\n"
    simulation = project.write("bot.urdf", description).write("bot.yaml", driven).load().simulation
    simulation.articulation(simulation.stage.find("/bot")).select(["arm_joint"]).command(**{kind: [value]})
    points = simulation.set_points
    commanded = [abs(number) for number in (*points.targets.ravel(), *points.efforts.ravel()) if number]
    assert max(commanded) == pytest.approx(float(beyond.rpartition(" ")[2]), rel=1e-5)
    assert simulation.clamped_commands == {beyond: 1}
