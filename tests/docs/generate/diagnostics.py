"""The page of finding codes: each with the explanation that `graphrun explain` prints."""

from __future__ import annotations

import re
from collections.abc import Iterator

from graphengine.cli.explain import RELATED, explanation, groups, heading

_INTRODUCTION = """# Diagnostics

`graphrun check`, and every verb that loads a file, reports errors, warnings and notes. Each has a code, the position in
the file, the reason, and in most cases a remedy. The first letter of the code gives the severity. G (in graphs) and S
(in scenes) are errors; a file with an error cannot run. W are warnings; if there are only warnings, `graphrun check`
exits with 1 only with `--strict`. N are notes.

`graphrun explain G204` prints the explanation of a code, and `graphrun explain` lists all codes. To try an example,
save its files to an empty folder and run its command there."""
_NOT_CHECKED = "<!-- not run: the file has the mistake; tests/cli/test_explain.py checks it -->"


def pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the page: a list of all codes, then their explanations."""
    text = [_INTRODUCTION]
    for title, codes in groups():
        text.append(f"**{title}**\n\n" + "\n".join(f"- {_link(code)}" for code in codes))
    for title, codes in groups():
        text.append(f"## {title}")
        text += [f"### {heading(code)}\n\n{_body(code)}" for code in codes]
    yield "diagnostics.md", "\n\n".join(text) + "\n"


def _body(code: str) -> str:
    """Return the explanation of a code with links to related codes, and without headings of its own."""
    text = RELATED.sub(lambda line: f"- {_link(line[1])}", explanation(code))
    text = re.sub(r"^## (.*)$", r"**\1**", text, flags=re.MULTILINE)
    return re.sub(r"^(?=```yaml title)", f"{_NOT_CHECKED}\n\n", text, flags=re.MULTILINE)


def _link(code: str) -> str:
    anchor = re.sub(r"[^\w -]", "", heading(code)).lower().replace(" ", "-")
    return f"[{heading(code)}](#{anchor})"
