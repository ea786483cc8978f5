"""Reads the routes of the actors of an SDF world."""

from __future__ import annotations

import itertools

from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.routes import PREFIX, Route
from graphengine.descriptions.sdf.sdf_values import SdfError, find, flag_at, number_at, pose_of
from graphengine.devices.rotation import compose
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import printable


def actors_at(world: Element, findings: Findings) -> list[Element]:
    """Return a list of the MJCF `<custom>` element with the routes of an SDF world's actors; empty without a trajectory.

    Raises:
        SdfError: a waypoint is not legal.
    """
    texts: list[Element] = []
    for actor in world.all("actor"):
        route = _route(actor)
        name = actor.get("name")
        if route is None or not name:
            text = f"actor {printable(name)!r} is left out: it has no name or no <trajectory> with waypoints"
            findings.add("W302", text, actor.span)
            continue
        texts.append(Element("text", {"name": f"{PREFIX}{name}", "data": route.text()}, actor.span))
        if actor.first("skin") is not None or actor.first("animation") is not None:
            text = f"actor {printable(name)!r} is drawn as a plain person that faces the way it walks"
            findings.add("N103", text, actor.span, "its skin and animations are not used")
    return [Element("custom", {}, world.span, texts)] if texts else []


def _route(actor: Element) -> Route | None:
    """Return the route of an actor; None if it has no waypoints."""
    script = find(actor, "script")
    waypoints = [each for path in (script.all("trajectory") if script else []) for each in path.all("waypoint")]
    if script is None or not waypoints:
        return None
    place = pose_of(actor.first("pose"))
    times = [number_at(each, "time", default=0.0) for each in waypoints]
    for (before, after), each in zip(itertools.pairwise(times), waypoints[1:], strict=True):
        if not 0.0 <= before <= after:
            raise SdfError(f"the times of waypoints must ascend: {after:g} s follows {before:g} s", each.span)
    places = [compose(place, pose_of(each.first("pose")))[0] for each in waypoints]
    ground = places[0][2]  # the origin of an actor is at its feet or at its hips, which depends on its skin
    points = [(time, x, y, z - ground) for time, (x, y, z) in zip(times, places, strict=True)]
    if points[0][0] > 0.0:  # Gazebo leaves an actor at its pose until its first time
        points.insert(0, (0.0, *points[0][1:]))
    loops = flag_at(script, "loop") is not False
    if flag_at(script, "auto_start") is False:  # the actor waits for a command that graphengine does not have
        points, loops = points[:1], False
    return Route(number_at(script, "delay_start", default=0.0), tuple(points), points[-1][0] if loops else 0.0)
