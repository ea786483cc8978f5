"""Descriptions of bases whose omni or mecanum wheels have modelled rollers, each on a joint of its own."""

from __future__ import annotations

import math
from collections.abc import Sequence

from tests.physics.bases import Base, Wheel

_INERTIA = '<inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'
HUB, RING, ROLLER = 0.04, 0.043, 0.012
"""Radius of a hub, distance of the rollers' axes from the axle, and radius of a roller, m."""


def rolling_radius(rollers: int, length: float) -> float:
    """Radius (m) with which a wheel rolls whose rollers are spherical cylinders of a length between their centres, m.

    It is the perimeter of the wheel's convex hull divided by 2 pi; the hull of equal arms is a polygon with rounded corners.
    """
    corners = []
    for number in range(rollers):
        angle = math.tau * number / rollers
        for end in (-length / 2, length / 2):
            x, z = RING * math.sin(angle) + end * math.cos(angle), RING * math.cos(angle) - end * math.sin(angle)
            corners.append((x, z))
    corners.sort(key=lambda corner: math.atan2(corner[1], corner[0]))
    sides = sum(math.dist(one, two) for one, two in zip(corners, [*corners[1:], corners[0]], strict=True))
    return sides / math.tau + ROLLER


def rolling_base(axles: Sequence[tuple[float, float, float, float]], rollers: int = 12, length: float = 0.016) -> str:
    """A base as URDF.

    Args:
        axles: x and y (m) of each wheel, the angle of its axle from the y axis, and the angle on the floor of its rollers' axes
            from the rolling direction, rad.
        rollers: number of rollers of a wheel.
        length: length of a roller between the centres of its round ends, m.
    """
    parts = [
        f'<link name="base_link"><inertial><origin xyz="0 0 0.03"/><mass value="6"/>{_INERTIA.format(0.06)}</inertial></link>'
    ]
    for number, (x, y, turn, slant) in enumerate(axles, 1):
        shape = f'<geometry><cylinder radius="{HUB}" length="0.02"/></geometry>'
        parts.append(
            f'<link name="wheel_{number}"><inertial><mass value="0.3"/>{_INERTIA.format(3e-4)}</inertial>'
            f'<collision><origin rpy="{math.pi / 2} 0 0"/>{shape}</collision>'
            "</link>"
            f'<joint name="wheel_{number}_joint" type="continuous"><parent link="base_link"/><child link="wheel_{number}"/>'
            f'<origin xyz="{x} {y} 0" rpy="0 0 {turn}"/><axis xyz="0 1 0"/></joint>'
        )
        parts += [_roller(number, each, math.tau * each / rollers, slant, length) for each in range(rollers)]
    return f'<robot name="roller">{"".join(parts)}</robot>'


def _roller(wheel: int, number: int, angle: float, slant: float, length: float) -> str:
    """A roller at an angle about the axle from the lowest point; its axis is the link's x axis."""
    x, z = -RING * math.sin(angle), -RING * math.cos(angle)
    name = f"wheel_{wheel}_roller_{number}"
    shape = f'<geometry><cylinder radius="{ROLLER}" length="{length}"/></geometry>'
    ends = "".join(
        f'<collision><origin xyz="{end} 0 0"/><geometry><sphere radius="{ROLLER}"/></geometry></collision>'
        for end in (-length / 2, length / 2)
    )
    return (
        f'<link name="{name}"><inertial><mass value="0.02"/>{_INERTIA.format(1e-5)}</inertial>'
        f'<collision><origin rpy="0 {math.pi / 2} 0"/>{shape}</collision>{ends}</link>'
        f'<joint name="{name}_joint" type="continuous"><parent link="wheel_{wheel}"/><child link="{name}"/>'
        f'<origin xyz="{x} 0 {z}" rpy="{_rpy(angle, slant)}"/><axis xyz="1 0 0"/></joint>'
    )


def _rpy(angle: float, slant: float) -> str:
    """Roll, pitch and yaw of a turn about the axle (y) after a turn of the roller's axis about the vertical (z)."""
    # R = Ry(angle) Rz(slant), as R = Rz(yaw) Ry(pitch) Rx(roll)
    c, s, cs, ss = math.cos(angle), math.sin(angle), math.cos(slant), math.sin(slant)
    first = (c * cs, ss, -s * cs)
    second_z, third_z = s * ss, c
    return (
        f"{math.atan2(second_z, third_z)} {math.asin(max(-1.0, min(1.0, -first[2])))} {math.atan2(first[1], first[0])}"
    )


THREE = [(0.15 * math.cos(a), 0.15 * math.sin(a), a - math.pi / 2, 0.0) for a in (math.pi / 3, math.pi, -math.pi / 3)]
"""Three omni wheels in a triangle, whose axles point outwards."""
FOUR = [(x, y, 0.0, -math.copysign(math.pi / 4, x * y)) for x in (0.15, -0.15) for y in (0.12, -0.12)]
"""Four mecanum wheels."""
PLAIN = Base(
    "plain", tuple(Wheel(f"w{n}", x, y, heading=turn) for n, (x, y, turn, _) in enumerate(THREE)), 0.05, 0.02, 6.0
)
"""Three omni wheels without rollers."""
