"""Follows the links of Markdown files: to files, anchors and pictures."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from urllib.parse import unquote

from tests.cli.harness import ROOT
from tests.docs.pages import DOCS, Link, anchors, links

INCLUDED = ("CHANGELOG.md", "CONTRIBUTING.md")
"""Files that a page of the site includes, so that a relative link means another place there."""
PICTURES = (".gif", ".jpg", ".mp4", ".png", ".svg", ".webp")


def broken_links(path: Path, root: Path = ROOT, docs: Path = DOCS) -> Iterator[str]:
    """Yield a text for each link of a page that leads nowhere, or not for all of its readers."""
    for link in links(path.read_text(encoding="utf-8")):
        if problem := _problem(path, link, root, docs):
            yield f"{path.relative_to(root)}:{link.line}: {link.target}: {problem}"


def _problem(path: Path, link: Link, root: Path, docs: Path) -> str:
    if ":" in link.target.partition("/")[0]:
        return "" if link.target.startswith(("https://", "mailto:")) else "only https:// leads out of the repository"
    file, _, anchor = link.target.partition("#")
    found = (path.parent / unquote(file)).resolve() if file else path
    if path.name in INCLUDED and file:
        return "the site includes this file: name the page in backticks"
    if not found.is_relative_to(root) or not found.exists():
        return "there is no such file"
    if path.is_relative_to(docs) and not found.is_relative_to(docs):
        return "the site has no such page: name the file in backticks"
    if link.is_picture:
        return "" if found.suffix in PICTURES and found.stat().st_size else "this is no picture"
    if path.is_relative_to(docs) and found.is_dir():
        return "the site has no folders: link to a page"
    if anchor and anchor not in _anchors(found):
        return f"there is no heading with this anchor in {found.name}"
    return ""


@cache
def _anchors(path: Path) -> set[str]:
    return anchors(path.read_text(encoding="utf-8")) if path.suffix == ".md" else set()


def tracked(root: Path = ROOT) -> set[Path]:
    """Return the files below docs/ that git knows; all of them outside of a checkout."""
    listed = subprocess.run(["git", "ls-files", "docs"], cwd=root, capture_output=True, text=True, check=False)
    files = [root / name for name in listed.stdout.splitlines()]
    return set(files) or {path for path in (root / "docs").rglob("*") if path.is_file()}
