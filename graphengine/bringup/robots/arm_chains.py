"""Finds the arms of a robot, i.e. chains of joints with position drives, and their grippers."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence

from graphengine.descriptions.robot_description import Joint, RobotDescription

_FINGER = 4
"""Maximum number of joints of a finger; a longer branch is an arm."""
_ONLY, _ARM = 2, 3
"""Minimum number of joints of the only chain, and of joints that belong to no other chain, for the chain to be an arm."""


def arm_chains(description: RobotDescription, driven: Collection[str]) -> list[tuple[str, ...]]:
    """Return the joints of each arm, from the base to the flange.

    A joint that several chains share, such as that of a torso, belongs to an arm only if the robot has no other arm.

    Args:
        description: robot description.
        driven: names of joints with position drives, without joints of a base and mimic joints.
    """
    above = {joint.name: _above(description, joint) for joint in description.moving()}
    paths = _paths(above, driven)
    inner = {name for path in paths.values() for name in path[:-1]}
    fingers = {name for hand in _hands(above, paths) for name in hand}
    chains: dict[tuple[str, ...], None] = {}
    for path in (path for name, path in paths.items() if name not in inner):
        first = next((number for number, name in enumerate(path) if name in fingers), len(path))
        if first:
            chains[tuple(path[:first])] = None
    if len(chains) == 1:
        return [chain for chain in chains if len(chain) >= _ONLY]
    own = {chain: _own(chain, chains) for chain in chains}
    arms = [chain for chain in chains if len(own[chain]) >= _ARM]
    return arms if len(arms) == 1 else [own[chain] for chain in arms]


def gripper_joints(description: RobotDescription, driven: Collection[str]) -> list[str]:
    """Return the driven joint of each gripper with a single driven joint; the other fingers mimic this joint."""
    above = {joint.name: _above(description, joint) for joint in description.moving()}
    hands = _hands(above, _paths(above, driven))
    leaders = [[name for name in hand if name in driven] for hand in hands]
    return [hand[0] for hand in leaders if len(hand) == 1]


def _paths(above: dict[str, list[str]], driven: Collection[str]) -> dict[str, list[str]]:
    """Return a dict from each driven joint to the driven joints between the root and this joint, including it."""
    return {name: [each for each in [*above[name], name] if each in driven] for name in above if name in driven}


def _above(description: RobotDescription, joint: Joint) -> list[str]:
    """Return the names of the moving joints between the root and a joint, starting at the root."""
    return [carrier.name for carrier in description.carriers(joint.parent) if carrier.moves][::-1]


def _hands(above: dict[str, list[str]], paths: dict[str, list[str]]) -> list[list[str]]:
    """Return the first joints of the fingers of each hand, where a chain branches into fingers.

    Branches are fingers if none of them has enough joints for an arm, and if they are not an arm and the rods of a linkage.
    """
    branches: defaultdict[str, list[str]] = defaultdict(list)
    depths: defaultdict[str, int] = defaultdict(int)
    lengths: defaultdict[str, int] = defaultdict(int)
    for name, carriers in above.items():
        if carriers:
            branches[carriers[-1]].append(name)
        for number, each in enumerate([*carriers, name]):
            lengths[each] = max(lengths[each], len(carriers) + 1 - number)
    for path in paths.values():
        for number, name in enumerate(path):
            depths[name] = max(depths[name], len(path) - number)
    hands = [hand for hand in branches.values() if len(hand) > 1 and max(depths[name] for name in hand) <= _FINGER]
    return [hand for hand in hands if not _is_linkage(hand, depths, lengths)]


def _is_linkage(branches: Sequence[str], depths: Mapping[str, int], lengths: Mapping[str, int]) -> bool:
    """Return whether one branch continues an arm, and the others are shorter rods without drives.

    Args:
        branches: first joint of each branch.
        depths: number of driven joints in the longest chain that begins at a joint.
        lengths: number of moving joints in the longest chain that begins at a joint.
    """
    driven = [name for name in branches if depths.get(name)]
    rods = [name for name in branches if not depths.get(name)]
    return len(driven) == 1 and depths[driven[0]] > 1 and all(lengths[name] < lengths[driven[0]] for name in rods)


def _own(chain: tuple[str, ...], chains: Collection[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the joints of a chain that belong to no other chain."""
    shared = {name for other in chains if other != chain for name in other}
    return tuple(name for name in chain if name not in shared)
