"""Physics materials: PhysX mixes two of them at each contact, MuJoCo takes one collider's numbers, so mixing is done at build.

PhysX has a static and a dynamic friction for each of two colliders and a rule to combine them; where the rules differ, the
later of average, min, multiply, max counts. MuJoCo takes the maximum of both, unless one collider has the higher `priority`,
whose friction, condim and solref then count alone. So a bound collider is given a priority and what PhysX would have made of
it and the floor. That holds against walls too, where it matters less.

Of a material with friction in two directions the greater one is mixed. The lesser keeps its ratio to it, as rollers turn as
easily on any floor; `dynamics.directed_friction` applies the ratio to each contact.

Two things have no counterpart. MuJoCo has one coefficient of friction; the dynamic one is taken for it. And its contacts are
springs with damping, which at steps of 4 ms return a part of the speed that depends on when in a step they are met: 0.34 to 0.55
of it where half is wanted. So restitution is left out.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from graphengine.format.robot_spec import MaterialSpec

RULES = {"average": "average", "min": "lesser", "multiply": "product", "max": "greater"}
"""Ways to combine two numbers, in words; where two materials differ in it, the later one counts."""
_COMBINED: dict[str, Callable[[float, float], float]] = {
    "average": lambda first, second: (first + second) / 2,
    "min": min,
    "multiply": operator.mul,
    "max": max,
}
FLOOR_RULE = "average"
"""PhysX's default, for the floor: MJCF has no such rule."""
NO_FLOOR_FRICTION = 0.5
"""PhysX's friction of a collider without a material, taken where the world has no plane to read it from."""

STIFF_SOLREF = (0.004, 1.0)
"""Time constant (s) and damping ratio of a contact that sinks in by 1/25 of MuJoCo's default.

A wheel rolls on its radius less half the penetration: 0.9998 of it with this, 0.9982 by default. A collider that slides with
friction chatters with it (a caster at 0.4 costs 6 % of yaw rate at random), so those keep the default."""
DEFAULT_SOLREF = (0.02, 1.0)


@dataclass(frozen=True, slots=True)
class Contact:
    """Contact parameters of a collider in MuJoCo."""

    friction: float
    condim: int
    priority: int
    solref: tuple[float, float]

    def tell(self, geom: Any) -> None:
        """Apply the parameters to a geom of a compiled or editable model."""
        geom.friction[0] = self.friction
        geom.condim = self.condim
        geom.priority = self.priority
        geom.solref = self.solref


def stronger(first: str, second: str) -> str:
    """Return the one of two combine modes that PhysX uses."""
    return max(first, second, key=list(RULES).index)


def combine(first: float, second: float, rule: str) -> float:
    """Return one number for two, as PhysX combines them."""
    return _COMBINED[rule](first, second)


def greatest_friction(material: MaterialSpec) -> float:
    """The friction of a material in the direction in which it grips most."""
    return max(material.dynamic_friction, material.across or 0.0)


def against_floor(material: MaterialSpec, floor: float, *, wheel: bool) -> Contact:
    """Return the contact parameters of a material on a floor with a given friction.

    Without friction the contact has one dimension and the higher priority, so that no other collider adds friction.
    """
    friction = combine(greatest_friction(material), floor, stronger(material.combine, FLOOR_RULE))
    if friction == 0:
        return Contact(0.0, 1, 2, STIFF_SOLREF)
    return Contact(friction, 3, 1, STIFF_SOLREF if wheel else DEFAULT_SOLREF)


def sentences(name: str, material: MaterialSpec, floor: float) -> tuple[str, ...]:
    """Return a text on the friction that results, then one on what was left out; empty if the file says all of it."""
    static, restitution, dynamic = material.static_friction, material.restitution, greatest_friction(material)
    rule = stronger(material.combine, FLOOR_RULE)
    friction = combine(dynamic, floor, rule)
    own = f"its {dynamic:g}" if static == dynamic else f"its dynamic {dynamic:g}"
    outcome = f"friction {friction:g}" if friction else "no friction"
    if friction and material.across is not None:
        along, across = (friction * part / dynamic for part in (material.dynamic_friction, material.across))
        outcome = f"friction {along:g} along its direction and {across:g} across it"
    text = f"material {name!r}: {outcome} on the floor, the {RULES[rule]} of {own} and the floor's {floor:g}"
    chosen = "combine" in material.model_fields_set and rule in ("min", "max")
    if chosen and friction != dynamic and material.across is None:
        text += ": the material's value has no effect"
    written = "static_friction" in material.model_fields_set
    lost = [f"static friction ({static:g})"] if written and static != dynamic else []
    lost += [f"restitution ({restitution:g})"] if restitution else []
    if chosen and friction == dynamic and not lost:
        return ()
    return (text, f"left out, as MuJoCo has no such thing: {', '.join(lost)}") if lost else (text,)
