"""The arms of a robot: chains of joints with position drives, each without its gripper."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection

from graphengine.physics.description.urdf import Urdf, UrdfJoint

_FINGER = 4
"""Most joints of a finger; a longer branch is an arm."""
_ONLY, _ARM = 2, 3
"""Least number of joints of an arm that is the only chain of joints, and that one of several has for itself."""


def arm_chains(urdf: Urdf, driven: Collection[str]) -> list[tuple[str, ...]]:
    """Return the joints of each arm, from its base to its flange.

    Joints that several chains share, such as that of a torso, belong to an arm only if it is the only one.

    Args:
        urdf: the description.
        driven: joints with position drives, except those of a base and those that follow another.
    """
    above = {joint.name: _above(urdf, joint) for joint in urdf.moving()}
    paths = {name: [each for each in [*above[name], name] if each in driven] for name in above if name in driven}
    inner = {name for path in paths.values() for name in path[:-1]}
    fingers = _fingers(above, paths)
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


def _above(urdf: Urdf, joint: UrdfJoint) -> list[str]:
    """Names of the moving joints that carry a joint, from the root on."""
    found: list[str] = []
    carrier = urdf.links[joint.parent].carrier
    while carrier is not None:
        if carrier.moves:
            found.append(carrier.name)
        carrier = urdf.links[carrier.parent].carrier
    return found[::-1]


def _fingers(above: dict[str, list[str]], paths: dict[str, list[str]]) -> set[str]:
    """Joints at which an arm branches into fingers: into several branches, none of which is long enough for an arm."""
    branches: defaultdict[str, set[str]] = defaultdict(set)
    depths: defaultdict[str, int] = defaultdict(int)
    for name, carriers in above.items():
        if carriers:
            branches[carriers[-1]].add(name)
    for path in paths.values():
        for number, name in enumerate(path):
            depths[name] = max(depths[name], len(path) - number)
    split = (each for each in branches.values() if len(each) > 1 and max(depths[name] for name in each) <= _FINGER)
    return {name for each in split for name in each}


def _own(chain: tuple[str, ...], chains: Collection[tuple[str, ...]]) -> tuple[str, ...]:
    """The joints of a chain that are in no other."""
    shared = {name for other in chains if other != chain for name in other}
    return tuple(name for name in chain if name not in shared)
