"""The YAML form of ROS parameter files, which `graphrun param dump` prints and `graphrun param load` reads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from graphengine.format.errors import UsageError

EVERY_NODE = "/**"
"""Key of a parameter file whose parameters apply to all nodes."""
KEY = "ros__parameters"


def nested(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values with dotted names as nested mappings; `a.b` stays one key if `a` has a value too."""
    tree: dict[str, Any] = {}
    for name in sorted(values):
        place, rest = tree, name
        while "." in rest:
            part, _, below = rest.partition(".")
            inner = place.setdefault(part, {})
            if not isinstance(inner, dict):
                break
            place, rest = inner, below
        place[rest] = values[name]
    return tree


def read(path: Path, *, wildcard: bool) -> Mapping[str, Any]:
    """Return a dict from the parameters in a file to their values without nulls; as in ros2, node names are ignored.

    Args:
        path: the file.
        wildcard: whether to include the parameters below `/**`.

    Raises:
        CheckError: the file is not YAML.
        UsageError: the file has no parameters, or a list whose elements have different types.
    """
    from graphengine.format import document
    from graphengine.format.diagnostics import Findings
    from graphengine.messages.parameters import ParameterType, fitting_type

    findings = Findings()
    found = document.load(path, findings)
    findings.raise_errors()
    data = found.data if found is not None else None
    nodes = data if isinstance(data, dict) else {}
    order = ([EVERY_NODE] if wildcard else []) + [node for node in nodes if node != EVERY_NODE]
    values: dict[str, Any] = {}
    for node in order:
        given = nodes.get(node)
        if isinstance(given, dict) and isinstance(given.get(KEY), dict):
            values |= {name: value for name, value in flat(given[KEY]) if value is not None}
    if not values:
        raise UsageError(f"{path}: no parameters; write them below NODE: {KEY}:")
    for name, value in values.items():
        if isinstance(value, list) and fitting_type(value) is ParameterType.NOT_SET:
            legal = "write only booleans, only integers, only numbers or only texts"
            raise UsageError(f"{path}: {name} is not a list of values of one type; {legal}")
    return values


def flat(tree: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the dotted name and the value of each leaf of nested mappings; names begin with the prefix `above`."""
    for key, value in tree.items():
        if isinstance(value, dict):
            yield from flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value
