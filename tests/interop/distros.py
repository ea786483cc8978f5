"""What differs on the wire between the distributions of ROS 2 whose message types are known."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from graphengine.messages.definitions import Definitions, shipped
from graphengine.messages.distros import DISTROS


@cache
def types_of(definitions: Definitions) -> set[str]:
    """Return all types of a distribution: messages, services, actions and their parts."""
    return {part for name in definitions.names() for part in definitions.closure(name)}


@cache
def hashes() -> dict[str, list[str]]:
    """Return the type hash of each type in each distribution, in their order; empty where it is unknown."""
    known = [(definitions, types_of(definitions)) for definitions in map(shipped, DISTROS)]
    names = sorted(set[str]().union(*(names for _, names in known)))
    return {name: [one.type_hash(name) if name in its else "" for one, its in known] for name in names}


def fields() -> dict[str, list[tuple[str, ...]]]:
    """Return the types whose own fields differ between distributions: the fields of each that others lack.

    The hashes of the types that contain them differ too.
    """
    found = {}
    for name, given in hashes().items():
        lines = [_lines(shipped(distro), name) for distro, known in zip(DISTROS, given, strict=True) if known]
        if len(set(lines)) > 1:
            common = set(lines[0]).intersection(*lines)
            every = iter(lines)
            own = (next(every) if known else () for known in given)
            found[name] = [tuple(line for line in one if line not in common) for one in own]
    return found


def containing(names: set[str]) -> set[str]:
    """Return the types whose hashes differ only because they contain others."""
    differing = {name for name, given in hashes().items() if len({one for one in given if one}) > 1}
    return differing - names


def missing() -> Iterator[tuple[str, list[bool]]]:
    """Yield the messages, services and actions that some distribution lacks, and which have them."""
    every = [set(shipped(distro).names()) for distro in DISTROS]
    for name in sorted(set[str]().union(*every)):
        if not all(name in known for known in every):
            yield name, [name in known for known in every]


def _lines(definitions: Definitions, name: str) -> tuple[str, ...]:
    """Return the fields of a type as lines of its definition, without constants."""
    definition = definitions.definition(name)
    return tuple(line for line in str(definition).splitlines() if line and "=" not in line)
