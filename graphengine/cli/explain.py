"""`graphrun explain`: explain finding codes: the cause, an example that produces the finding, and the remedy.

The folder `explanations` has one Markdown file for each code: the cause, `## Example`, `## Remedy`, and `## Related` codes.
"""

from __future__ import annotations

import argparse
import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path

from graphengine.cli import terminal
from graphengine.cli.finding_formats import coloured
from graphengine.cli.options import add_value
from graphengine.format.diagnostics import CODES, GROUPS, Finding
from graphengine.format.errors import UsageError
from graphengine.format.wording import unknown

FOLDER = Path(__file__).parent / "explanations"
WIDEST = 100
"""Maximum number of columns of the text on a wider terminal."""
RELATED = re.compile(r"^- ([GSWN]\d{3})$", re.MULTILINE)
"""Matches a line of an explanation that names a related code."""

_BLOCK = re.compile(r"^(```.*?^```)$", re.MULTILINE | re.DOTALL)
_DIFF_COLOURS = {"-": "31", "+": "32"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun explain` to its parser."""
    code = "code of an error, warning or note, such as G204; without a code, all codes are listed"
    add_value(parser, "codes", "CODE", code, nargs="*")


def execute(arguments: argparse.Namespace) -> int:
    """Print the explanations of the given codes, or a list of all codes; return 0.

    Raises:
        UsageError: a code does not exist.
    """
    codes = list(dict.fromkeys(code.upper() for code in arguments.codes))
    for code in codes:
        if code not in CODES:
            raise UsageError(f"{unknown('code', code, CODES)}\n  `graphrun explain` lists all codes")
    if codes:
        print("\n\n\n".join("\n\n".join(_parts(code)) for code in codes))
    else:
        lists = (
            f"{_painted(title, '1')}\n" + "\n".join(f"  {code}  {CODES[code]}" for code in codes)
            for title, codes in groups()
        )
        print("\n\n".join(lists))
    return 0


def groups() -> Iterator[tuple[str, list[str]]]:
    """Yield the title and the codes of each group."""
    for prefix, title in GROUPS.items():
        yield title, [code for code in CODES if code.startswith(prefix)]


def explanation(code: str) -> str:
    """Return the explanation of a code, without its title, as Markdown."""
    return (FOLDER / f"{code}.md").read_text("utf-8").strip()


def heading(code: str) -> str:
    """Return a code with its title."""
    return f"{code}: {CODES[code]}"


def _parts(code: str) -> Iterator[str]:
    """Yield title, paragraphs, headings and indented blocks of an explanation, for the terminal."""
    finding = Finding(code, CODES[code])
    yield coloured(finding, finding.render()) if terminal.uses_colours(sys.stdout) else finding.render()
    text = RELATED.sub(lambda line: f"- {heading(line[1])}", explanation(code))
    for number, part in enumerate(_BLOCK.split(text)):
        if number % 2:
            yield _block(part)
        else:
            yield from map(_paragraph, filter(None, map(str.strip, part.split("\n\n"))))


def _paragraph(text: str) -> str:
    """Return a heading in bold, or a paragraph or list with its lines filled to the width of the terminal."""
    if text.startswith("## "):
        return _painted(text[3:], "1")
    options = {"width": min(terminal.width(sys.stdout), WIDEST), "break_on_hyphens": False, "break_long_words": False}
    items = re.split(r"\n(?=- )", text)
    return "\n".join(textwrap.fill(item, subsequent_indent="  " * item.startswith("- "), **options) for item in items)  # type: ignore[arg-type]


def _block(block: str) -> str:
    """Return the name of a code block's file, and below it the indented lines of the block; lines of a diff are coloured."""
    first, *lines, _ = block.split("\n")
    name = re.search(r'title="(.*)"', first)
    if first.startswith("```diff"):
        lines = [_painted(line, _DIFF_COLOURS.get(line[:1], "")) for line in lines]
    return "\n".join([*([f"  {name[1]}"] if name else []), *(f"    {line}".rstrip() for line in lines)])


def _painted(text: str, colour: str) -> str:
    """Return the text, in a colour if standard output takes colours; `colour` is the parameter of the escape sequence SGR."""
    return f"\x1b[{colour}m{text}\x1b[0m" if colour and terminal.uses_colours(sys.stdout) else text
