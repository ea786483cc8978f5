"""Combines the physics materials of robots with the floor's friction when a model is built.

PhysX combines the materials of both colliders at each contact. Each collider has a static friction, a dynamic friction and a
combine mode; if the modes differ, PhysX uses the later one in the order average, min, multiply, max. MuJoCo uses the greater
friction of both colliders, unless one collider has a higher `priority`: then the friction, condim and solref of that collider
apply. So a collider with a material gets a higher priority, and the friction that PhysX would compute for it on the floor. This
friction also applies to contacts with walls, where it matters less.

For a material with different friction in two directions, the greater friction is combined. The ratio of both frictions is kept,
because rollers turn equally easily on any floor; `dynamics.directed_friction` applies the ratio to each contact.

Two properties of PhysX materials have no counterpart in MuJoCo. MuJoCo has a single coefficient of friction, which is set to the
dynamic friction. Restitution is ignored: MuJoCo's contacts are damped springs, and with steps of 4 ms the rebound speed depends
on when in a step the contact begins (0.34 to 0.55 of the impact speed for a restitution of 0.5).
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from graphengine.format.robot_spec import MaterialSpec

RULES = {"average": "average", "min": "lesser", "multiply": "product", "max": "greater"}
"""Combine modes with the words for them in messages; if two materials differ in the mode, the later one of these is used."""
_COMBINED: dict[str, Callable[[float, float], float]] = {
    "average": lambda first, second: (first + second) / 2,
    "min": min,
    "multiply": operator.mul,
    "max": max,
}
FLOOR_RULE = "average"
"""Combine mode of the floor: the default of PhysX, because MJCF has no combine modes."""
NO_FLOOR_FRICTION = 0.5
"""Floor friction in a world without a plane: that of a PhysX collider without a material."""

STIFF_SOLREF = (0.004, 1.0)
"""Time constant (s) and damping ratio of wheel contacts; wheels sink into the floor 1/25 as deep as with MuJoCo's default.

A wheel rolls on its radius minus half the penetration: 0.9998 of the radius with these values, 0.9982 with the default. Colliders
that slide with friction would chatter with these values (a caster with friction 0.4 costs a random 6 % of yaw rate), so they keep
the default."""
DEFAULT_SOLREF = (0.02, 1.0)


@dataclass(frozen=True, slots=True)
class Contact:
    """MuJoCo's contact parameters of a collider."""

    friction: float
    condim: int
    priority: int
    solref: tuple[float, float]

    def tell(self, geom: Any) -> None:
        """Write the parameters to a geom of a compiled model or of an MjSpec."""
        geom.friction[0] = self.friction
        geom.condim = self.condim
        geom.priority = self.priority
        geom.solref = self.solref


def stronger(first: str, second: str) -> str:
    """Return the combine mode that PhysX uses at a contact of two materials with the given modes."""
    return max(first, second, key=list(RULES).index)


def combine(first: float, second: float, rule: str) -> float:
    """Return the friction of a contact, computed from the frictions of both colliders by a combine mode of PhysX."""
    return _COMBINED[rule](first, second)


def greatest_friction(material: MaterialSpec) -> float:
    """Return the friction of a material in the direction in which the friction is greatest."""
    return max(material.dynamic_friction, material.across or 0.0)


def against_floor(material: MaterialSpec, floor: float, *, wheel: bool) -> Contact:
    """Return the contact parameters of a material on a floor with a given friction.

    A contact without friction gets a condim of 1 and an even higher priority, so that no other collider adds friction to it.
    """
    friction = combine(greatest_friction(material), floor, stronger(material.combine, FLOOR_RULE))
    if friction == 0:
        return Contact(0.0, 1, 2, STIFF_SOLREF)
    return Contact(friction, 3, 1, STIFF_SOLREF if wheel else DEFAULT_SOLREF)


def sentences(name: str, material: MaterialSpec, floor: float) -> tuple[str, ...]:
    """Return a sentence on a material's friction on the floor, and one on properties that are ignored, if there are any.

    Return no sentence if the robot file gives a combine mode that keeps the material's friction, and no property is ignored.
    """
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
    return (text, f"ignored, because MuJoCo does not support it: {', '.join(lost)}") if lost else (text,)
