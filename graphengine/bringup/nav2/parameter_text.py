"""Writes a ROS parameter file from a template; a comment beside each value names the source of the value.

A template has the lines of the parameter file, with each value on one line. A comment in the template names the source of the
value in its line. A literal without a comment comes from Nav2's own parameter file. The caller passes the values for placeholders
such as `$b`, and the facts for conditions:

| template | meaning |
|---|---|
| `a: $b` | the given value `b` with its source, unless the line has another source; `-$b` is its negative |
| `a: 1  # $b` | 1, with the source of the given value `b` |
| `a: 1  # if b and not c` | only if the fact `b` holds and `c` does not; in a line without a value, for all lines below it |
| `a: 1  # busy: 2` | 2 instead of 1 if the fact `busy` holds |
| `$a:` | the lines below it for each name in the given value `a`, with the further values of this name |
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import yaml

from graphengine.bringup.nav2.sourced import NAV2, Sourced
from graphengine.format.templates import Facts, holds
from graphengine.format.yaml_text import comment

BUSY = "to tolerate a busy machine (--busy)"
_LINE = re.compile(
    r"(?P<indent> *)(?P<name>[^:]+):(?: (?P<value>[^ ].*?))?"
    r"(?:  # (?:if (?P<condition>[\w ]+)(?:; |$))?(?:busy: (?P<busy>\S+))?(?P<source>.*))?"
)


def parameter_lines(template: Sequence[str], given: Mapping[str, Any], facts: Facts) -> Iterator[str]:
    """Yield the lines of a parameter file.

    Args:
        template: lines of the template.
        given: values, with their sources as `Sourced` unless the template has the source.
        facts: facts for the conditions, including `busy`.
    """
    while template:
        line = _LINE.fullmatch(template[0])
        assert line is not None
        indent, name = line["indent"], line["name"]
        below = [number for number, other in enumerate(template) if number and not other.startswith(f"{indent} ")]
        end = min(below, default=len(template))
        block, template = template[1:end], template[end:]
        if line["condition"] and not holds(line["condition"], facts):
            continue
        if line["value"]:
            yield f"{indent}{name}: {_value(line, given, facts)}"
            continue
        for each, more in given[name[1:]].items() if name.startswith("$") else [(name, {})]:
            yield f"{indent}{each}:"
            yield from parameter_lines(block, {**given, **more}, facts)


def _value(line: re.Match[str], given: Mapping[str, Any], facts: Facts) -> str:
    """Return the value of a line, and its source as a comment."""
    text, source = line["value"], line["source"]
    if line["busy"] and facts["busy"]:
        text, source = line["busy"], BUSY
    elif "$" in text:
        found = given[text.lstrip("-$")]
        value, own = (found.value, found.source) if isinstance(found, Sourced) else (found, None)
        text, source = _scalar(_negative(value) if text.startswith("-") else value), source or own
    elif source and source.startswith("$"):
        source = given[source[1:]].source
    return f"{text}  {comment(source or NAV2)}"


def _negative(value: Any) -> Any:
    return [-one for one in value] if isinstance(value, list) else -value


def _scalar(value: Any) -> str:
    """Return a value as YAML on one line; floats have a decimal point, because ROS derives the type from it."""
    if isinstance(value, float):
        value = float(f"{value:.6g}") + 0.0  # without the sign of zero
    elif isinstance(value, list):
        return f"[{', '.join(map(_scalar, value))}]"
    text = yaml.safe_dump(value, default_flow_style=True, width=10**9)
    return text.removesuffix("\n").removesuffix("\n...")
