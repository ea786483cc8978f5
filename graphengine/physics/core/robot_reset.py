"""Returns one robot to its initial state, while the rest of the simulation continues."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING

from graphengine.descriptions.engine import mujoco
from graphengine.devices.stage import Prim
from graphengine.format.prim_paths import at_or_below
from graphengine.physics.dynamics.keyframes import start_robot, with_followers
from graphengine.physics.dynamics.set_points import SetPoints
from graphengine.physics.dynamics.solver_errors import out_of_range
from graphengine.physics.dynamics.start_state import drives_of
from graphengine.physics.dynamics.transfer import Transfer

if TYPE_CHECKING:
    from graphengine.physics.core.simulation_core import SimulationCore


@contextmanager
def robot_reset(
    simulation: SimulationCore, robot: Prim, joints: Mapping[str, float], keyframe: str | None
) -> Iterator[None]:
    """Set the joints of a robot to their initial state; after the `with` block, reset commands, pushes and sensors as well.

    All velocities become zero. The block can place the robot elsewhere. If the block raises an error, the simulation is
    unchanged.

    Raises:
        PhysicsError: MuJoCo cannot compute poses for these joint positions; nothing has changed.

    Args:
        simulation: the simulation.
        robot: prim of the robot.
        joints: a dict from the name of a joint that does not mimic another one to its position, rad or m; other joints return to
            their initial positions.
        keyframe: keyframe of the robot's own model, instead of the initial state; None for the initial state.
    """
    prefix, model, before = f"{robot.entity_name}/", simulation.model, copy.copy(simulation.data)
    start = simulation.initial_state()
    positions = with_followers(model, prefix, joints)
    chosen = robot.facts["keyframes"][keyframe] if keyframe is not None else None
    start_robot(robot, model, start, positions, chosen, others=chosen is not None)
    start.qvel[:], start.time = 0.0, simulation.data.time
    Transfer(model, model, prefix).carry_over(start, simulation.data)
    try:
        simulation.refresh()
        if simulation.data.warning[mujoco.mjtWarning.mjWARN_BADQPOS].number:
            raise out_of_range(model, simulation.data)
        yield
    except BaseException:
        mujoco.mj_copyData(simulation.data, simulation.model, before)
        simulation.refresh()
        raise
    commands = SetPoints(model, start, list(drives_of(simulation.stage)))
    Transfer(model, simulation.model, prefix).carry_over_commands(commands, simulation.set_points)
    simulation.set_points.pending = True
    simulation.limits.start(prefix)
    simulation.pushes.clear(prefix)
    for placed in [placed for path, placed in simulation.held.items() if at_or_below(path, robot.path)]:
        simulation.let_go(placed.body)
    for weld, (body, _) in list(simulation.welds.held.items()):
        if weld.startswith(prefix) or body.startswith(prefix):
            simulation.welds.release(weld)
    simulation.refresh()
    simulation.handles.reset(robot.path)
