"""Arms and legs as chains of joints, for imports."""

from __future__ import annotations

from itertools import pairwise

from tests.bringup.robots.descriptions import INERTIA

PLATE = f'<link name="plate"><inertial><mass value="5"/>{INERTIA}</inertial></link>'
BALL = '<collision><geometry><sphere radius="0.03"/></geometry></collision>'
LIMIT = '<limit lower="-2" upper="2" effort="20" velocity="1"/>'
MIMIC = '<mimic joint="{0}finger"/>'


def joint(name: str, parent: str, more: str = LIMIT, kind: str = "revolute") -> str:
    """A link that turns on another one; both have the name of the joint."""
    return f"""<link name="{name}"><inertial><mass value="0.2"/>{INERTIA}</inertial>{BALL}</link>
<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{name}"/>
  <origin xyz="0 0 0.1"/><axis xyz="0 1 0"/>{more}
</joint>"""


def arm(length: int, parent: str, prefix: str = "", *, gripper: bool = False) -> str:
    """A chain of joints prefix_joint_1, …, and two fingers, the second of which follows the first."""
    names = [parent, *(f"{prefix}joint_{number}" for number in range(1, length + 1))]
    parts = [joint(name, carrier) for carrier, name in pairwise(names)]
    if gripper:
        parts.append(joint(f"{prefix}finger", names[-1]))
        parts.append(joint(f"{prefix}other_finger", names[-1], LIMIT + MIMIC.format(prefix)))
    return "\n".join(parts)


def bolted(*parts: str) -> str:
    weld = '<joint name="weld" type="fixed"><parent link="world"/><child link="plate"/></joint>'
    return f'<robot name="bot"><link name="world"/>{PLATE}{weld}{"".join(parts)}</robot>'
