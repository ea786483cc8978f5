"""What differs on the wire between the distributions of ROS 2 whose message types are known."""

from __future__ import annotations

import itertools

from graphengine.messages.definitions import Definitions, shipped
from graphengine.messages.distros import DISTROS
from graphengine.messages.interfaces import Definition


def messages_of(definitions: Definitions) -> list[str]:
    """Return the message types of a distribution, including parts of services and actions."""
    names = {name for name in definitions.names() if definitions.definition(name).is_message}
    others = set(definitions.names()) - names
    parts = (part for name in others for part in definitions.parts(name))
    return sorted(names.union(parts))


def hashes() -> dict[str, list[str]]:
    """Return the type hash of each message in each distribution, in their order; empty where it is unknown."""
    every = {distro: messages_of(shipped(distro)) for distro in DISTROS}
    names = sorted(set(itertools.chain.from_iterable(every.values())))
    return {name: [shipped(d).type_hash(name) if name in every[d] else "" for d in DISTROS] for name in names}


def differing() -> dict[str, list[str]]:
    """Return the types that exist in several distributions with different hashes: what each has in place of the others."""
    found: dict[str, list[str]] = {}
    for name, types in hashes().items():
        if len({type_hash for type_hash in types if type_hash}) > 1:
            known = [shipped(d).definition(name) if given else None for d, given in zip(DISTROS, types, strict=True)]
            found[name] = [_own_fields(one, known) for one in known]
    return found


def partial() -> dict[str, list[bool]]:
    """Return the types that some distributions lack, and which have them."""
    return {name: [bool(one) for one in types] for name, types in hashes().items() if not all(types)}


def _own_fields(one: Definition | None, others: list[Definition | None]) -> str:
    """Return the fields of a definition that another lacks; all of its types differ if there are none."""
    if one is None:
        return "-"
    shared = [set(map(repr, other.fields)) for other in others if other is not None]
    names = [name for name, kind in one.fields if not all(repr((name, kind)) in fields for fields in shared)]
    lines = str(one).splitlines()
    return ", ".join(f"`{line}`" for line in lines if line.split()[-1:] and line.split()[-1] in names) or "as before"
