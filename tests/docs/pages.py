"""The Markdown files that users read: their blocks of code, links, headings and commands."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.cli.harness import ROOT

DOCS = ROOT / "docs"
SITE = sorted(path for path in DOCS.rglob("*.md") if path != DOCS / "pictures/README.md")
"""The pages of the site."""
OTHERS = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
OTHERS += sorted(path for folder in ("examples", "ros", "docs/pictures") for path in (ROOT / folder).rglob("README.md"))
PAGES = [*SITE, *OTHERS]

_FENCE = re.compile(
    r"^(?P<indent> *)(?P<ticks>```+)(?P<language>\w*)(?: title=\"(?P<title>[^\"]+)\")? *\n(?P<text>.*?)^(?P=indent)(?P=ticks) *$",
    re.MULTILINE | re.DOTALL,
)
_NOT_RUN = re.compile(r"<!-- not run: [^>]+ -->\s*\Z")
_LINK = re.compile(r"(?P<picture>!?)\[(?P<text>(?:!\[[^\]]*\]\([^)]*\)|[^\[\]])*)\]\((?P<target>[^()\s]+)\)")
_IMAGE = re.compile(r"<img [^>]*src=\"(?P<target>[^\"]+)\"")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, the name of the file that it is, whether it is only parsed, and the line of its fence."""

    language: str
    title: str
    text: str
    runs: bool
    line: int


@dataclass(frozen=True)
class Link:
    """A link or picture: where it leads, and the line that it is in."""

    target: str
    is_picture: bool
    line: int


def name_of(path: Path) -> str:
    return str(path.relative_to(ROOT))


def blocks(text: str) -> Iterator[Block]:
    """Yield the blocks of a page in their order."""
    for found in _FENCE.finditer(text):
        lines = found["text"].splitlines(keepends=True)
        body = "".join(line.removeprefix(found["indent"]) for line in lines)
        line = text.count("\n", 0, found.start()) + 1
        yield Block(
            found["language"],
            found["title"] or "",
            body,
            not _NOT_RUN.search(text[: found.start()].rstrip() + "\n"),
            line,
        )


def is_run(text: str) -> bool:
    """Return whether the commands of a page are run."""
    return text.startswith("<!-- run -->")


def prose(text: str) -> str:
    """Return a page with empty lines in the place of its blocks and comments, so that lines keep their numbers."""
    text = _FENCE.sub(lambda found: "\n" * found[0].count("\n"), text)
    return re.sub(r"<!--.*?-->", lambda found: "\n" * found[0].count("\n"), text, flags=re.DOTALL)


def quoted(text: str) -> Iterator[tuple[int, str]]:
    """Yield the texts in backticks, outside of blocks, with their lines."""
    for number, line in enumerate(prose(text).splitlines(), 1):
        yield from ((number, found) for found in re.findall(r"(?<!`)`([^`]+)`(?!`)", line))


def links(text: str) -> Iterator[Link]:
    """Yield the links and pictures of a page, those within links too."""
    for number, line in enumerate(re.sub(r"`[^`\n]*`", "``", prose(text)).splitlines(), 1):
        for found in _LINK.finditer(line):
            yield Link(found["target"], bool(found["picture"]), number)
            yield from (Link(inner["target"], True, number) for inner in _LINK.finditer(found["text"]))
        yield from (Link(found["target"], True, number) for found in _IMAGE.finditer(line))


def anchors(text: str) -> set[str]:
    """Return the anchors of the headings of a page, as GitHub and the site make them."""
    heads = re.findall(r"^#{1,6} +(.+?) *#*$", prose(text), re.MULTILINE)
    plain = [re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", head) for head in heads]
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in plain}
