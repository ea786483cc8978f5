"""Simulates a robot at rest on a flat floor to find the links that carry the weight, and the position of the centre of mass.

A link on the floor that does not roll forward would brake the robot, so the link is bound to a material without friction.
"""

from __future__ import annotations

import copy
import math
from collections import defaultdict
from collections.abc import Collection, Mapping

import numpy as np

from graphengine.bringup.robots.base_graph import GRAPH
from graphengine.bringup.robots.skid_steering import GRAVITY, OFF_CENTRE
from graphengine.bringup.robots.trial import FLOOR_FRICTION, trial_model, trial_spec
from graphengine.descriptions.engine import Floats, body_names, collides, mujoco
from graphengine.descriptions.geoms import extents
from graphengine.descriptions.robot_description import WORLD
from graphengine.descriptions.robot_files.draft import Draft, RobotWheel
from graphengine.descriptions.robot_files.entries import Entry, MaterialKeys, material
from graphengine.format.wording import printable
from graphengine.physics.dynamics.contact_forces import contact_points
from graphengine.physics.model.robot import RobotInstance

NAME = "CasterMaterial"
MOST_JOINTS = 120
"""Maximum number of moving joints of a robot that the import simulates on a floor; more joints would take too long."""
STEP = 1 / 240
"""Physics step, s; the same as in a scene."""
SECONDS = 2.0
"""Simulated time, s."""
MEASURED = 0.25
"""Last part of the simulated time, over which contact forces are averaged, s."""
PROBE = 1.0
"""Largest simulated acceleration, which shows how the load shifts from wheel to wheel, m/s2."""
SETTLED = 0.5
"""Time for the load to shift, s."""
STIFF = 1e5
"""Damping that keeps joints without a drive in their positions while the base comes to rest, N m s/rad or N s/m."""
LEANING = 1.0
"""Tilt of the root link above which the import adds a remark, because a tilted lidar sees the floor, degrees."""
FALLEN = math.cos(math.radians(20))
"""Cosine of the tilt beyond which a robot counts as fallen."""
LEAST_SHARE = 0.001
"""Minimum fraction of the weight that a link on the floor carries."""
NEAR = 0.01
"""Maximum height (m) above the floor of links that count as touching it, because the robot can pitch."""


def add_rest(draft: Draft) -> None:
    """Add remarks on a wheeled robot at rest on a floor, and free links that do not roll forward from friction."""
    standing = [wheel for wheel in draft.wheels.values() if wheel.on_floor and not wheel.drags]
    driven = [wheel for wheel in standing if not wheel.swivels]
    if draft.fixed_base or draft.description.root == WORLD:
        return
    _tell_lifted(draft)
    if not driven:
        return
    if len(draft.description.moving()) > MOST_JOINTS:
        draft.notice(f"with more than {MOST_JOINTS} moving joints the robot is not simulated on a floor")
        return
    trial = trial_spec(draft)
    model = _model(draft, *trial) if trial is not None else None
    if model is None:
        return
    data = _at_rest(model)
    if data is None or data.body(draft.description.root).xmat[8] < FALLEN:
        draft.notice("on a flat floor the robot does not come to rest on its wheels")
        return
    tilt = math.degrees(math.acos(min(float(data.body(draft.description.root).xmat[8]), 1.0)))
    if tilt > LEANING:
        draft.notice(f"on a flat floor the robot leans by {tilt:.1f} degrees")
    _tell_centre(draft, model, data, driven)
    wheels = {link for wheel in standing for link in (wheel.link, *wheel.rollers.links)}
    forces = _forces(model, data)
    _tell_idle(draft, standing, forces)
    _tell_slipping(draft, driven, model, data, forces)
    near = [link for link in _near(draft, model, data) if link not in wheels]
    _free(draft, {link: force for link, force in forces.items() if link not in wheels}, near, sum(forces.values()))


def _model(draft: Draft, spec: mujoco.MjSpec, robot: RobotInstance) -> mujoco.MjModel | None:
    """Return a model of the robot on a plane; None without colliders, or if MuJoCo refuses the model.

    Joints without a drive that carry no wheel are strongly damped.
    """
    options = spec.option
    options.timestep, options.integrator = STEP, mujoco.mjtIntegrator.mjINT_DISCRETE
    options.cone, options.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0
    carrying: set[str] = set()
    for wheel in draft.wheels.values():
        carrying |= {*wheel.rollers.joints, *(joint.name for joint in draft.description.carriers(wheel.link))}
    for moving in robot.moving:
        if moving.name not in carrying and moving.name not in robot.drives:
            spec.joint(moving.name).damping[0] = STIFF
    model = trial_model(draft, spec)
    if model is None:
        return None
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    reach = extents(model, data, np.flatnonzero(collides(model)))
    if reach is None:
        return None
    height = float(reach[0][2]) - 0.001
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    spec.worldbody.add_geom(type=plane, size=[0, 0, 1], pos=[0, 0, height], friction=[FLOOR_FRICTION, 0.005, 0.0001])
    return trial_model(draft, spec)


def _at_rest(model: mujoco.MjModel) -> mujoco.MjData | None:
    """Return the state of the robot at rest; None if the simulation diverges."""
    data = mujoco.MjData(model)
    for _ in range(round((SECONDS - MEASURED) / STEP)):
        mujoco.mj_step(model, data)
    diverged = any(warning.number for warning in data.warning) or not np.isfinite(data.qpos).all()
    return None if diverged else data


def _forces(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """Simulate `MEASURED` seconds; return a dict from links on the floor to the mean vertical force of the floor, N."""
    names, forces = body_names(model), defaultdict[str, float](float)
    steps = round(MEASURED / STEP)
    for _ in range(steps):
        mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        contacts = contact_points(model, data)
        for force, bodies in zip(contacts.forces, contacts.bodies.tolist(), strict=True):
            if 0 in bodies:
                forces[names[max(bodies)]] += abs(float(force[2])) / steps
    return forces


def _tell_lifted(draft: Draft) -> None:
    """Add a remark if another link reaches further down than the driven wheels of a base."""
    lowest = min(draft.standing, key=draft.standing.__getitem__, default="")
    driven = [wheel for wheel in draft.wheels.values() if "drive" in draft.joints[wheel.joint].value]
    if GRAPH not in draft.graphs or not lowest or not driven or any(wheel.on_floor for wheel in driven):
        return
    height = min(wheel.centre[2] - wheel.radius for wheel in driven) - draft.standing[lowest]
    text = f"the driven wheels are {1000 * height:.3g} mm above the lowest collider, that of {printable(lowest)}"
    colliders = draft.description.links[lowest].colliders
    draft.notice(f"{text}; they may not reach the floor", colliders[0].span if colliders else None)


def _tell_idle(draft: Draft, standing: list[RobotWheel], forces: dict[str, float]) -> None:
    """Add a remark on wheels near the floor that carry no weight, because other links reach further down."""
    weight = sum(forces.values())
    idle = [
        wheel.link
        for wheel in standing
        if sum(forces.get(link, 0.0) for link in (wheel.link, *wheel.rollers.links)) < LEAST_SHARE * weight
    ]
    if idle:
        text = f"wheels that carry no weight, as others reach further down: {', '.join(map(printable, idle))}"
        draft.notice(f"{text}; they do not drive the base, and a mecanum base slides on a slope")


def _tell_slipping(
    draft: Draft, wheels: list[RobotWheel], model: mujoco.MjModel, data: mujoco.MjData, forces: dict[str, float]
) -> None:
    """Add remarks on acceleration limits of the graph above which the driven wheels slip."""
    graph = draft.graphs.get(GRAPH)
    known = graph.value["parameters"] if graph is not None else {}
    frictions = {
        link: _friction(draft, link)
        for wheel in wheels
        if "drive" in draft.joints[wheel.joint].value
        for link in (wheel.link, *wheel.rollers.links)
    }
    held = _held(frictions, forces)
    for name, verb, sign in (("acceleration", "starts", -1.0), ("deceleration", "stops", 1.0)):
        limit = known.get(name, 0.0)
        if not (held and limit):
            continue
        tried = min(PROBE, held / 2.0)
        shifted = _held(frictions, _forces_under(model, data, sign * tried))
        # the load shifts in proportion to the acceleration, until the driven wheels carry all weight
        share = min((shifted - held) / tried, 1.0 - held / (max(frictions.values()) * GRAVITY))
        grip = held / (1.0 - share)
        if limit > grip:
            text = f"the driven wheels grip up to {grip:.2g} m/s2 as the robot {verb}, and slip beyond, "
            draft.notice(f"{text}so it {verb} later than with {name} {limit:g} m/s2")


def _held(frictions: Mapping[str, float], forces: Mapping[str, float]) -> float:
    """Return the largest acceleration (m/s2) of the robot by the friction of links.

    Args:
        frictions: a dict from the links of driven wheels to their friction coefficients on the floor.
        forces: a dict from links on the floor to the vertical force of the floor, N.
    """
    held = sum(forces.get(link, 0.0) * friction for link, friction in frictions.items())
    return held / sum(forces.values()) * GRAVITY if held else 0.0


def _forces_under(model: mujoco.MjModel, data: mujoco.MjData, along: float) -> dict[str, float]:
    """Return the vertical forces of `_forces` under an additional acceleration `along` the robot's x axis, m/s2."""
    braked, gravity = copy.copy(data), model.opt.gravity.copy()
    model.opt.gravity[0] = along
    for _ in range(round(SETTLED / STEP)):
        mujoco.mj_step(model, braked)
    forces = _forces(model, braked)
    model.opt.gravity[:] = gravity
    return forces


def _friction(draft: Draft, link: str) -> float:
    """Return the friction coefficient between a link and the floor, along the direction of the link's material."""
    bound = draft.bound()
    return min(bound[link]["dynamic_friction"], FLOOR_FRICTION) if link in bound else FLOOR_FRICTION


def _near(draft: Draft, model: mujoco.MjModel, data: mujoco.MjData) -> list[str]:
    """Return the names of links whose colliders reach down to less than `NEAR` above the floor."""
    floor, solid = data.geom_xpos[model.geom_bodyid == 0][0][2], np.flatnonzero(collides(model))
    found: list[str] = []
    for link in draft.description.links:
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link)
        reach = extents(model, data, solid[model.geom_bodyid[solid] == body]) if body > 0 else None
        if reach is not None and reach[0][2] < floor + NEAR:
            found.append(link)
    return found


def _free(draft: Draft, forces: dict[str, float], near: list[str], weight: float) -> None:
    """Bind links on or near the floor to a material without friction, and add remarks on links that carry weight.

    Args:
        draft: draft of the robot file.
        forces: a dict from links other than wheels to the vertical force of the floor, N.
        near: names of links other than wheels near the floor.
        weight: sum of all vertical forces, N.
    """
    resting = {link: force for link, force in forces.items() if force > LEAST_SHARE * weight}
    dragging = {wheel.link for wheel in draft.wheels.values() if wheel.drags}
    for link, force in resting.items():
        rolls = "rolls only sideways" if link in dragging else "does not roll"
        text = f"{force:.3g} N, {force / weight:.0%} of the weight, rest on {link}, which {rolls}"
        colliders = draft.description.links[link].colliders
        draft.notice(text, colliders[0].span if colliders else None)
    _slide(draft, resting)
    if links := [link for link in dict.fromkeys([*resting, *near]) if link not in draft.bound()]:
        comment = "without friction: links that touch the floor and do not roll forward would brake the robot"
        draft.materials[NAME] = Entry(material(0.0, "min", links), [comment])


def _slide(draft: Draft, resting: Collection[str]) -> None:
    """Let links with friction on the floor slide by Coulomb's law, because MuJoCo's own contacts would make them jump."""
    for name, entry in [*draft.materials.items()]:
        friction = entry.value["dynamic_friction"]
        links = [link for link in entry.value["bind"] if link in resting]
        if not links or not friction or "direction" in entry.value:
            continue
        steady: MaterialKeys = {
            "across": friction,
            "direction": [1.0, 0.0, 0.0],
            "expressed_in": draft.description.root,
            "steady_sliding": True,
            "bind": links,
        }
        comments = [*entry.comments, "they rest on the floor and do not roll, so they slide with an even load"]
        draft.materials[f"{name}_sliding"] = Entry(entry.value | steady, comments)
        draft.unbind(name, links)


def _tell_centre(draft: Draft, model: mujoco.MjModel, data: mujoco.MjData, driven: list[RobotWheel]) -> None:
    """Add remarks on a centre of mass to one side of the wheels' middle, and for a skid-steered base ahead of or behind it."""
    root = data.body(draft.description.root)
    centre = root.xmat.reshape(3, 3).T @ (data.subtree_com[model.body_rootid[root.id]] - root.xpos)
    axle, places = np.array(driven[0].axle), np.array([wheel.centre for wheel in driven])
    off = _off_centre(places @ axle, float(centre @ axle))
    if off:
        text = f"the centre of mass lies {abs(off) * 1000:.0f} mm to one side of the middle of its wheels, "
        text += "so the base drifts when wheels slip, as those of a skid-steer base do in a turn"
        draft.notice(text)
    ahead = np.cross(axle, (0.0, 0.0, 1.0))
    off = _off_centre(places @ ahead, float(centre @ ahead)) * math.copysign(1.0, ahead[0])
    if off and draft.controller_track is not None:
        side = "ahead of" if off > 0.0 else "behind"
        text = f"the centre of mass lies {abs(off) * 1000:.0f} mm {side} the middle of its wheels, so the skid-steered base "
        text += f"turns about a point {side} its middle, with a shorter track than with even loads"
        draft.notice(text)


def _off_centre(wheels: Floats, centre: float) -> float:
    """Return the offset of the centre of mass from the middle of the wheels along an axis, m; 0 if it is small.

    Args:
        wheels: position of each wheel on the axis, m.
        centre: position of the centre of mass on the axis, m.
    """
    off = centre - float(wheels.mean())
    return off if abs(off) > OFF_CENTRE * float(np.ptp(wheels)) > 0.0 else 0.0
