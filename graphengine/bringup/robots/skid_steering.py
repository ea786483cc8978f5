"""Chooses friction, track and speed limits of a skid-steered base.

Let a base have the track T and the wheelbase B, and its wheels the friction f along and a across their rolling direction. On the
spot, this base turns like a base of two wheels with the track T (1 + (a B / (f T))^2): with this track, the moments of the
friction along and across the wheels balance by Coulomb's law. In arcs the base also needs a force towards the centre. This force
changes the track by a few percent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.bringup.robots.base import Base, Grip
from graphengine.descriptions.robot_description import RobotDescription
from graphengine.descriptions.robot_files.draft import Draft, RobotWheel
from graphengine.descriptions.robot_files.entries import MaterialKeys
from graphengine.devices.rotation import rotate

NAME = "wheels"
"""Name of the material of skid-steered wheels in the robot file."""
ALONG = 1.0
"""Friction of a wheel along its rolling direction, if the description has none."""
_SAME_TRACK = 0.25
"""Largest a B / (f T) at which a single track suits all arcs within 5 %."""
_ONE_TRACK = f"{_SAME_TRACK:g} track / wheelbase across, for which one track serves all arcs within 5 %"
HELD = 0.15
"""Largest share of the friction across that the force towards the centre of an arc may take, at the guessed limits."""
_SPEED, _SLOWEST, _TURN = 1.0, 0.5, 1.5
"""Largest and smallest guessed speed limit (m/s), and largest guessed limit of the turn rate (rad/s)."""
_UNITS = {"speed": "m/s", "turn": "rad/s"}
GRAVITY = 9.81
_SKIDS = 1.02
"""Smallest ratio of a controller's track to the distance of the wheels at which the controller compensates for skidding."""
OFF_CENTRE = 0.05
"""Offset of the centre of mass from the middle of the wheels above which the turns of a base change, as a fraction of the wheels'
distance along the same axis."""
_STEEP = 0.18
"""Friction across the wheels below which the import adds a remark on the slope at which a parked robot slides."""
SMALL = 0.75
"""Largest radius of a caster without a drive, as a fraction of the radius of the driven wheels."""


def casters(driven: Sequence[RobotWheel], parallel: Sequence[RobotWheel]) -> list[RobotWheel]:
    """Return the undriven wheels that stand in for casters beside one driven axle: small ones, or ones with `cast` in a name."""
    names = {wheel.joint for wheel in driven}
    limit = SMALL * max(wheel.radius for wheel in driven)
    loose = [wheel for wheel in parallel if wheel.joint not in names]
    named = [wheel for wheel in loose if any("cast" in text.lower() for text in (wheel.joint, wheel.link))]
    return [wheel for wheel in loose if wheel in named or wheel.radius < limit] if len(driven) == 2 else []


def choose_grip(draft: Draft, base: Base, links: Sequence[str], track: float, wheelbase: float, aside: float) -> Grip:
    """Return the friction of skid-steered wheels: that of the description, else a friction that suits the controller's track.

    If the centre of mass lies to one side, the friction is never equal in all directions: the wheels on the light side would
    slide more than the others, and the base would turn about a point far from its middle.

    Args:
        draft: draft with the materials of the description.
        base: base as its source describes it.
        links: links of the wheels.
        track: distance between the left and right wheels, m.
        wheelbase: distance between the foremost and the rearmost wheels, m.
        aside: distance of the centre of mass from the middle between the left and right wheels, m.
    """
    if (found := _described(draft, links)) is not None:
        return found
    across = ALONG * min(1.0, _SAME_TRACK * track / wheelbase)
    told = controller_track(base, track)
    if told is not None:
        exact, equal = (math.log(effective_track(track, wheelbase, each) / told) for each in (across, ALONG))
        if abs(equal) < abs(exact):
            if aside <= OFF_CENTRE * track:
                return Grip(ALONG, ALONG, f"equal in all directions, as the track {told:.4g} m of {base.source} needs")
            reason = "it needs equal friction, with which the base would turn about a point to one side, as its mass lies there"
            draft.lose(f"{base.source}: the track {told:.4g} m for turns: {reason}", base.span)
            return Grip(ALONG, round(across, 3), _ONE_TRACK, replaces_track=True)
    return Grip(ALONG, round(across, 3), _ONE_TRACK)


def controller_track(base: Base, track: float) -> float | None:
    """Return the track with which the controller of a base compensates for skidding, m; None if it does not compensate.

    Args:
        base: base as its source describes it.
        track: distance between the left and right wheels, m.
    """
    told = (base.track or track) * base.multiplier
    return told if told > _SKIDS * track else None


def effective_track(track: float, wheelbase: float, ratio: float) -> float:
    """Return the track of a base of two wheels that turns on the spot like a skid-steered base, m.

    Args:
        track: distance between the left and right wheels, m.
        wheelbase: distance between the foremost and the rearmost wheels, m.
        ratio: friction across the wheels divided by the friction along them.
    """
    return track * (1.0 + (ratio * wheelbase / track) ** 2)


def _described(draft: Draft, links: Sequence[str]) -> Grip | None:
    """Return the friction of the wheels in the description; None unless all wheels have the same friction."""
    bound = draft.bound()
    found = {_along_and_across(draft, bound[link], link) if link in bound else None for link in links}
    first = found.pop()
    if found or first is None:
        return None
    along, across = first
    return Grip(along, across, "of mu1 and mu2 in the description", described=True) if along > 0.0 else None


def _along_and_across(draft: Draft, value: MaterialKeys, link: str) -> tuple[float, float]:
    first = value["dynamic_friction"]
    second = value.get("across", draft.second_frictions.get(link, first))
    if "direction" in value and not _rolls_along(draft.description, value):
        return second, first
    return first, second


def _rolls_along(description: RobotDescription, value: MaterialKeys) -> bool:
    """Return whether the direction of a material is nearer to the root link's x axis than to its y axis."""
    turn = description.pose_in_root(value["expressed_in"])[1] if value.get("expressed_in") else (0.0, 0.0, 0.0, 1.0)
    x, y, z = value["direction"]
    forward, left, _ = rotate(turn, (x, y, z))
    return abs(forward) >= abs(left)


def guess_limits(draft: Draft, grip: Grip, known: Mapping[str, Any], rim_speed: float) -> dict[str, float]:
    """Return the limits `speed` (m/s) and `turn` (rad/s) that the base's source does not give, and add remarks on them.

    Args:
        draft: receives the remarks.
        grip: friction of the wheels.
        known: parameters of the graph, including limits of the base's source.
        rim_speed: largest speed of the wheels' rims, m/s; infinite without a limit.
    """
    budget = HELD * grip.across * GRAVITY
    turn = float(known.get("turn") or _TURN)
    speed = min(max(budget / turn, _SLOWEST), _SPEED, rim_speed)
    speed = float(known.get("speed") or speed)
    turn = float(known.get("turn") or min(_TURN, budget / speed))
    rounded = {name: math.floor(1000.0 * value + 1e-6) / 1000.0 for name, value in (("speed", speed), ("turn", turn))}
    found = {name: value for name, value in rounded.items() if value and not known.get(name)}  # 0 would mean no limit
    draft.guessed_turn = "turn" in found
    if found:
        shown = ", ".join(f"{name} {value:g} {_UNITS[name]}" for name, value in found.items())
        outcome = f"arcs then need at most {HELD:g} of the grip across the wheels"
        if speed * turn > 1.001 * budget:
            outcome = f"with accelerations above {budget:.2g} m/s2 towards the centre, arcs slide outwards"
        draft.guess(f"limits of the skid-steered base: {shown}; {outcome}")
    if grip.across < _STEEP:
        slope = math.degrees(math.atan(grip.across))
        text = f"parked across a slope, the robot slides from {slope:.1f} degrees on: friction {grip.across:g} across its wheels"
        draft.notice(text)
    return found
