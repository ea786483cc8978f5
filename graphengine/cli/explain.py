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
from graphengine.format.diagnostics import CODES, Finding
from graphengine.format.errors import UsageError
from graphengine.format.wording import unknown

FOLDER = Path(__file__).parent / "explanations"
GROUPS = {
    "G1": "Errors: reading a file",
    "G2": "Errors: nodes and connections",
    "G3": "Errors: prims, joints and ROS 2 names",
    "G4": "Errors: import and export",
    "S1": "Errors: scenes, worlds and robots",
    "W1": "Warnings: graphs",
    "W2": "Warnings: worlds and robots",
    "W3": "Warnings: import",
    "N1": "Notes: graphs, worlds and robots",
    "N3": "Notes: import",
}
"""Title of each group of codes, by the first two characters of the codes."""
INTRODUCTION = """# Diagnostics

`graphrun check`, and every verb that loads a file, reports errors, warnings and notes. Each has a code, the position in
the file, the reason, and in most cases a remedy. The first letter of the code is the severity: G (graphs) and S
(scenes) are errors, with which a file cannot run; W are warnings, with which `graphrun check` fails only with
`--strict`; N are notes.

`graphrun explain G204` prints the explanation of a code, and `graphrun explain` lists all codes. To try an example,
save its files to an empty folder and run its command there."""
"""Beginning of the reference page."""
WIDEST = 100
"""Maximum number of columns of the text on a wider terminal."""

_BLOCK = re.compile(r"^(```.*?^```)$", re.MULTILINE | re.DOTALL)
_RELATED = re.compile(r"^- ([GSWN]\d{3})$", re.MULTILINE)
_DIFF_COLOURS = {"-": "31", "+": "32"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun explain` to its parser."""
    code = "code of an error, warning or note, such as G204; without a code, all codes are listed"
    parser.add_argument("codes", metavar="CODE", nargs="*", help=code)
    parser.add_argument("--markdown", action="store_true", help="print the explanations of all codes as Markdown")


def execute(arguments: argparse.Namespace) -> int:
    """Print the explanations of the given codes, or a list of all codes; return 0.

    Raises:
        UsageError: a code does not exist, or codes are given together with `--markdown`.
    """
    codes = list(dict.fromkeys(code.upper() for code in arguments.codes))
    if codes and arguments.markdown:
        raise UsageError("--markdown prints all codes; leave out CODE or --markdown")
    for code in codes:
        if code not in CODES:
            raise UsageError(f"{unknown('code', code, CODES)}\n  `graphrun explain` lists all codes")
    if arguments.markdown:
        print(reference(), end="")
    elif codes:
        print("\n\n\n".join("\n\n".join(_parts(code)) for code in codes))
    else:
        lists = (f"{title}\n" + "\n".join(f"  {code}  {CODES[code]}" for code in codes) for title, codes in groups())
        print("\n\n".join(lists))
    return 0


def groups() -> Iterator[tuple[str, list[str]]]:
    """Yield the title and the codes of each group."""
    for prefix, title in GROUPS.items():
        yield title, [code for code in CODES if code.startswith(prefix)]


def explanation(code: str) -> str:
    """Return the explanation of a code, without its title, as Markdown."""
    return (FOLDER / f"{code}.md").read_text("utf-8").strip()


def reference() -> str:
    """Return the explanations of all codes as one page of Markdown, with a list of the codes at the top."""
    text = [INTRODUCTION]
    text += [f"**{title}**\n\n" + "\n".join(f"- {_link(code)}" for code in codes) for title, codes in groups()]
    for title, codes in groups():
        text.append(f"## {title}")
        for code in codes:
            body = _RELATED.sub(lambda line: f"- {_link(line[1])}", explanation(code))
            text += [f"### {_heading(code)}", re.sub(r"^## (.*)$", r"**\1**", body, flags=re.MULTILINE)]
    return "\n\n".join(text) + "\n"


def _heading(code: str) -> str:
    return f"{code}: {CODES[code]}"


def _link(code: str) -> str:
    """Return a link to the heading of a code on the reference page."""
    anchor = re.sub(r"[^\w -]", "", _heading(code)).lower().replace(" ", "-")
    return f"[{_heading(code)}](#{anchor})"


def _parts(code: str) -> Iterator[str]:
    """Yield title, paragraphs, headings and indented blocks of an explanation, for the terminal."""
    finding = Finding(code, CODES[code])
    yield coloured(finding, finding.render()) if terminal.uses_colours(sys.stdout) else finding.render()
    text = _RELATED.sub(lambda line: f"- {_heading(line[1])}", explanation(code))
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
    """Return the lines of a code block, indented, below the name of its file; lines of a diff are coloured."""
    first, *lines, _ = block.split("\n")
    name = re.search(r'title="(.*)"', first)
    if first.startswith("```diff"):
        lines = [_painted(line, _DIFF_COLOURS.get(line[:1], "")) for line in lines]
    return "\n".join([*([f"  {name[1]}"] if name else []), *(f"    {line}".rstrip() for line in lines)])


def _painted(text: str, colour: str) -> str:
    """Return the text in a colour, given by the parameter of the escape sequence SGR, if standard output takes colours."""
    return f"\x1b[{colour}m{text}\x1b[0m" if colour and terminal.uses_colours(sys.stdout) else text
