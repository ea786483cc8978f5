"""Physics materials: PhysX mixes two of them at each contact, MuJoCo takes one collider's numbers, so mixing is done at build.

PhysX has a static and a dynamic friction for each of two colliders and a rule to combine them; where the rules differ, the
later of average, min, multiply, max counts. MuJoCo takes the maximum of both, unless one collider has the higher `priority`,
whose friction, condim and solref then count alone. So a bound collider is given a priority and what PhysX would have made of
it and the floor. That holds against walls too, where it matters less.
"""

from __future__ import annotations

from dataclasses import dataclass

from graphengine.spec import MaterialSpec

RULES = ("average", "min", "multiply", "max")
NO_FLOOR_FRICTION = 0.5
"""PhysX's friction of a collider without a material, taken where the world has no plane to read it from."""

STIFF_SOLREF = (0.004, 1.0)
"""Time constant (s) and damping ratio of a contact that sinks in by 1/25 of MuJoCo's default.

A wheel rolls on its radius less half the penetration: 0.9998 of it with this, 0.9982 by default. A collider that slides with
friction chatters with it (a caster at 0.4 costs 6 % of yaw rate at random), so those keep the default."""
DEFAULT_SOLREF = (0.02, 1.0)


@dataclass(frozen=True, slots=True)
class Contact:
    """What MuJoCo is told about a collider."""

    friction: float
    condim: int
    priority: int
    solref: tuple[float, float]


def combine(first: float, second: float, rule: str) -> float:
    """One number out of two, as PhysX combines them."""
    match rule:
        case "average":
            return (first + second) / 2
        case "min":
            return min(first, second)
        case "multiply":
            return first * second
        case _:
            return max(first, second)


def against_floor(material: MaterialSpec, floor: float, *, wheel: bool) -> Contact:
    """The contact of a material with the floor, whose own rule is average.

    Dynamic friction counts, as MuJoCo has a single coefficient. Without friction the contact has one dimension and the higher
    priority, so that no other collider brings friction back in. Restitution has no counterpart: MuJoCo's contacts are springs
    with damping, and at steps of 4 ms one that should return half of the speed returns a fifth.
    """
    friction = combine(material.dynamic_friction, floor, material.combine)
    if friction == 0:
        return Contact(0.0, 1, 2, STIFF_SOLREF)
    return Contact(friction, 3, 1, STIFF_SOLREF if wheel else DEFAULT_SOLREF)


def sentence(name: str, material: MaterialSpec, floor: float, contact: Contact) -> str:
    """What was resolved, for people."""
    if contact.friction == 0:
        outcome = "frictionless (condim 1, priority 2)"
    else:
        outcome = f"friction {contact.friction:g} (priority {contact.priority})"
    unlike = material.static_friction != material.dynamic_friction
    both = ", its dynamic friction, as MuJoCo has no static one" if unlike else ""
    bounce = "; restitution is not simulated" if material.restitution else ""
    mixed = f"{material.combine} of {material.dynamic_friction:g}{both} and the floor's {floor:g}"
    return f"material {name!r}: {mixed}: {outcome}{bounce}"
