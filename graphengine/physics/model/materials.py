"""Converts physics materials to contact parameters of MuJoCo, combined with the friction of the floor.

PhysX combines the materials of both colliders at each contact. Each collider has a static and a dynamic friction and a combine
mode; if the modes differ, PhysX uses the later one in the order average, min, multiply, max. MuJoCo uses the greater friction of
both colliders, unless one has a higher `priority`: then this collider's friction, condim and solref apply. So a collider with a
material gets a higher priority, and the friction that PhysX would compute for it on the floor. This friction also applies to
contacts with walls, where it matters less.

For a material with friction in two directions, the greater friction is combined. The ratio of both is kept, because rollers turn
equally easily on any floor; `dynamics.directed_friction` applies the ratio to each contact.

Two properties of PhysX materials have no counterpart in MuJoCo. MuJoCo has a single coefficient of friction; it is set to the
dynamic friction. Restitution is ignored: MuJoCo's contacts are damped springs, and with steps of 4 ms the rebound speed depends
on when in a step the contact begins (0.34 to 0.55 of the impact speed for a restitution of 0.5).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from graphengine.format.robot_spec import MaterialSpec

_RULES: Mapping[str, tuple[str, Callable[[float, float], float]]] = {
    "average": ("average", lambda first, second: (first + second) / 2),
    "min": ("lesser", min),
    "multiply": ("product", operator.mul),
    "max": ("greater", max),
}
"""Combine modes with their names in messages and their functions.

If the modes of two materials differ, the later mode in this order is used.
"""
FLOOR_RULE = "average"
"""Combine mode of the floor. MJCF has no combine modes, so it is the default of PhysX."""
NO_FLOOR_FRICTION = 0.5
"""Floor friction for a world without a plane: the friction of a PhysX collider without a material."""

STIFF_SOLREF = (0.004, 1.0)
"""Time constant (s) and damping ratio of wheel contacts; bodies penetrate by 1/25 of the depth with MuJoCo's default.

A wheel rolls on its radius minus half the penetration: 0.9998 of the radius with these values, 0.9982 with the default. Colliders
that slide with friction would chatter (a caster with friction 0.4 costs a random 6 % of yaw rate), so they keep the default."""
DEFAULT_SOLREF = (0.02, 1.0)
STEADY_IMPEDANCE = 0.8
"""First two values of MuJoCo's `solimp` for wheels with `steady_sliding`; the default is 0.9 to 0.95.

Tyres give way by 0.2 mm. Four wheels on stiffer contacts are a table with four legs: errors of micrometres decide which two legs
carry the robot, and so how the robot turns."""


@dataclass(frozen=True, slots=True)
class Contact:
    """Contact parameters of a collider; the fields are attributes of a MuJoCo geom."""

    friction: float
    condim: int
    priority: int
    solref: tuple[float, float]
    impedance: float | None = None

    def tell(self, geom: Any) -> None:
        """Apply the parameters to a geom of a compiled or editable model."""
        geom.friction[0] = self.friction
        geom.condim = self.condim
        geom.priority = self.priority
        geom.solref = self.solref
        if self.impedance is not None:
            geom.solimp[:2] = self.impedance


def stronger(first: str, second: str) -> str:
    """Return the combine mode that PhysX uses at a contact of colliders with two given modes."""
    return max(first, second, key=list(_RULES).index)


def combine(first: float, second: float, rule: str) -> float:
    """Return the friction of a contact from the friction of both colliders, according to a combine mode of PhysX."""
    return _RULES[rule][1](first, second)


def greatest_friction(material: MaterialSpec) -> float:
    """Return the friction of a material in the direction with the greatest friction."""
    return max(material.dynamic_friction, material.across or 0.0)


def against_floor(material: MaterialSpec, floor: float, *, wheel: bool) -> Contact:
    """Return the contact parameters of colliders with a material on a floor with the given friction.

    Without friction, `condim` is 1, and the priority is higher than that of other materials. So no other collider adds friction.
    """
    friction = combine(greatest_friction(material), floor, stronger(material.combine, FLOOR_RULE))
    if friction == 0:
        return Contact(0.0, 1, 2, STIFF_SOLREF)
    impedance = STEADY_IMPEDANCE if wheel and material.steady_sliding else None
    return Contact(friction, 3, 1, STIFF_SOLREF if wheel else DEFAULT_SOLREF, impedance)


def sentences(name: str, material: MaterialSpec, floor: float) -> tuple[str, ...]:
    """Return a text on a material's friction on the floor and, if any, a text on properties that MuJoCo does not have.

    Return no text if the combine mode in the robot file keeps the material's friction, and no property is lost.
    """
    static, restitution, dynamic = material.static_friction, material.restitution, greatest_friction(material)
    rule = stronger(material.combine, FLOOR_RULE)
    friction = combine(dynamic, floor, rule)
    own = f"its {dynamic:g}" if static == dynamic else f"its dynamic {dynamic:g}"
    outcome = f"friction {friction:g}" if friction else "no friction"
    if friction and material.across is not None:
        along, across = (friction * part / dynamic for part in (material.dynamic_friction, material.across))
        outcome = f"friction {along:g} along its direction and {across:g} across it"
    text = f"material {name!r}: {outcome} on the floor, the {_RULES[rule][0]} of {own} and the floor's {floor:g}"
    chosen = "combine" in material.model_fields_set and rule in ("min", "max")
    if chosen and friction != dynamic and material.across is None:
        text += ": the material's value has no effect"
    written = "static_friction" in material.model_fields_set
    lost = [f"static friction ({static:g})"] if written and static != dynamic else []
    lost += [f"restitution ({restitution:g})"] if restitution else []
    if chosen and friction == dynamic and not lost:
        return ()
    return (text, f"without effect, because MuJoCo does not support it: {', '.join(lost)}") if lost else (text,)
