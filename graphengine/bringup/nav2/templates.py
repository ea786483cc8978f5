"""Fills in the templates beside this module, of which the Nav2 files of a scene are made."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib.resources import files
from string import Template

_CONDITIONAL = re.compile(r"^ *# if ([\w ]+)\n(.*?)^ *# end\n", re.MULTILINE | re.DOTALL)

Facts = Mapping[str, bool]
"""Whether each fact holds, by the name that conditions in templates use."""


def read(template: str) -> str:
    """Return the text of a template."""
    return files(__package__).joinpath(template).read_text(encoding="utf-8")


def holds(condition: str, facts: Facts) -> bool:
    """Return whether a condition such as `jazzy and not car` holds."""
    words = condition.split(" and ")
    return all(facts[word.removeprefix("not ")] != word.startswith("not ") for word in words)


def filled(template: str, facts: Facts | None = None, **values: str) -> str:
    """Return the text of a template with its placeholders replaced.

    The lines between `# if CONDITION` and `# end` are left out unless the condition holds.
    """
    text = _CONDITIONAL.sub(lambda found: found[2] if holds(found[1], facts or {}) else "", read(template))
    return Template(text).substitute(values)
