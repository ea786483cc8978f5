"""Fills in templates of text files: placeholders such as `$name`, and lines with a condition."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from string import Template

_CONDITIONAL = re.compile(r"^ *# if ([\w ]+)\n(.*?)^ *# end\n", re.MULTILINE | re.DOTALL)

Facts = Mapping[str, bool]
"""A dict from the name of each fact in conditions of templates to whether the fact holds."""


def holds(condition: str, facts: Facts) -> bool:
    """Return whether a condition such as `jazzy and not car` holds."""
    words = condition.split(" and ")
    return all(facts[word.removeprefix("not ")] != word.startswith("not ") for word in words)


def filled(template: Path, facts: Facts | None = None, /, **values: object) -> str:
    """Return the text of a template file with the placeholders filled in.

    The lines between `# if CONDITION` and `# end` are left out unless the condition holds.
    """
    text = template.read_text(encoding="utf-8")
    text = _CONDITIONAL.sub(lambda found: found[2] if holds(found[1], facts or {}) else "", text)
    return Template(text).substitute(values)
