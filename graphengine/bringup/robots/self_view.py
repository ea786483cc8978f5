"""Counts the beams of each ray sensor that end at the sensor's own robot, with all joints at their start positions.

Many descriptions have a lidar inside of a coarse collider, or behind a link that does not block the real lidar. This sensor then
gets `sees_own_robot: false`.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from graphengine.bringup.robots.trial import trial_model, trial_spec
from graphengine.descriptions.engine import body_names, mujoco
from graphengine.descriptions.robot_files.draft import Draft
from graphengine.descriptions.robot_files.entries import Entry, SensorKeys
from graphengine.devices.stage import Stage
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import PhysicsError
from graphengine.format.wording import listing
from graphengine.physics.implementations import IMPLEMENTATIONS
from graphengine.physics.model.robot_prims import add_robot
from graphengine.physics.sensors.lidar import RaySensor
from graphengine.physics.simulation import Simulation

CLOSE = 0.5
"""Distance up to which beams that end at the robot count as blocked, m."""
MOST_BLOCKED = 0.2
"""Fraction of blocked beams beyond which a sensor gets `sees_own_robot: false`."""


def check_self_view(draft: Draft) -> None:
    """Add `sees_own_robot: false` to sensors if their own robot blocks many beams, and remarks on all blocked beams."""
    kinds = [kind for kind, known in IMPLEMENTATIONS.all.items() if issubclass(known.handle, RaySensor)]
    casting = {name: entry for name, entry in draft.sensors.items() if entry.value.get("type") in kinds}
    simulation = _alone(draft) if casting else None
    if simulation is None:
        return
    for prim in [prim for kind in kinds for prim in simulation.stage.prims(kind)]:
        name = next(above.name for above in prim.ancestors() if above.name in casting)
        sensor: RaySensor[object] = simulation.device(IMPLEMENTATIONS.all[prim.kind].handle, prim)
        distances, geoms = sensor.cast()
        blocked = (distances >= 0.0) & (distances <= min(CLOSE, sensor.ranges[1]))
        names = body_names(simulation.model)
        bodies = dict.fromkeys(simulation.model.geom_bodyid[geoms[blocked]].tolist())
        if bodies:
            links = [names[body].partition("/")[2] for body in bodies]
            _report(draft, name, casting[name], float(np.mean(blocked)), listing(links, "by"))


def _report(draft: Draft, name: str, entry: Entry[SensorKeys], share: float, by: str) -> None:
    text = f"the robot itself blocks {share:.0%} of the beams of {name} within {CLOSE} m, {by}"
    if share > MOST_BLOCKED:
        entry.value["sees_own_robot"] = False
        entry.comments.append(text)
        text += "; with sees_own_robot: false, its beams pass through the robot"
    draft.notice(text)


def _alone(draft: Draft) -> Simulation | None:
    """Return a simulation of the robot in an empty world; None if the draft has errors or the model cannot be simulated."""
    trial = trial_spec(draft)
    if trial is None:
        return None
    spec, robot = trial
    world = mujoco.MjSpec()
    world.attach(spec, frame=world.worldbody.add_frame(), prefix=f"{robot.name}/")
    model = trial_model(draft, world)
    if model is None:
        return None
    stage = Stage()
    add_robot(stage, robot, set(body_names(model)), Findings())
    try:
        return Simulation(model, stage, Fraction(60), 1, rays="mujoco")
    except PhysicsError:
        return None
