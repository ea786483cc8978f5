"""The site: strictly built, every page in its navigation, links and anchors of its HTML, no markup left over."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import yaml

from tests.cli.harness import ROOT
from tests.docs.pages import DOCS, SITE


class _Tagged(yaml.SafeLoader):
    """Reads mkdocs.yml, in which tags stand for Python objects and environment variables."""


_Tagged.add_multi_constructor("!", lambda loader, tag, node: None)
_Tagged.add_multi_constructor("tag:yaml.org,2002:python/", lambda loader, tag, node: None)
SETTINGS: dict[str, Any] = yaml.load((ROOT / "mkdocs.yml").read_text(encoding="utf-8"), _Tagged)


def leaves(entries: list[Any]) -> Iterator[str]:
    """Yield the files of a navigation in their order."""
    for entry in entries:
        if isinstance(entry, str):
            yield entry
        else:
            (inner,) = entry.values()
            yield from leaves(inner if isinstance(inner, list) else [inner])


def test_every_page_is_once_in_the_navigation_and_every_entry_is_a_page() -> None:
    assert sorted(leaves(SETTINGS["nav"])) == sorted(str(path.relative_to(DOCS)) for path in SITE)


def test_every_page_is_built(site: Path) -> None:
    built = {str(path.relative_to(site).with_suffix(".md")) for path in site.rglob("*.html")} - {"404.md"}
    assert built == {str(path.relative_to(DOCS)) for path in SITE}


def test_every_link_of_the_html_leads_to_a_file_and_an_id(site: Path) -> None:
    pages = {path: path.read_text(encoding="utf-8") for path in site.rglob("*.html") if path.name != "404.html"}
    ids = {
        path: {html.unescape(name) for name in re.findall(r'\bid="?([^"\s>]+)', text)} for path, text in pages.items()
    }
    broken = []
    for path, text in pages.items():
        for target in re.findall(r'\b(?:href|src)="([^"]+)"', text):
            file, _, anchor = unquote(html.unescape(target)).partition("#")
            if re.match(r"[a-z]+:", file):
                continue
            found = (path.parent / file).resolve() if file else path
            if not found.is_file() or (anchor and found in ids and anchor not in ids[found] | {"__skip", "__search"}):
                broken.append(f"{path.relative_to(site)}: {target}")
    assert broken == []


BLOCK = re.compile(r"<pre\b.*?</pre>", re.DOTALL)
MARKUP = re.compile(r".{0,40}(?:```|\]\(|\*\*\w|!!! |^\|.*\|$).{0,40}", re.MULTILINE)


def test_no_markup_is_left_over_in_the_text(site: Path) -> None:
    left = []
    for path in site.rglob("*.html"):
        body = path.read_text(encoding="utf-8").partition("<article")[2].partition("</article>")[0]
        left += [
            f"{path.relative_to(site)}: {found}" for found in re.findall(r".{0,40}\\\|.{0,40}", BLOCK.sub("", body))
        ]
        text = re.sub(r"<(code|pre)\b.*?</\1>", "", body, flags=re.DOTALL)
        text = html.unescape(re.sub(r"<[^>]+>", "", text))
        left += [f"{path.relative_to(site)}: {found}" for found in MARKUP.findall(text)]
    assert left == []


def test_the_search_has_every_page_but_the_changelog(site: Path) -> None:
    index = json.loads((site / "search.json").read_text(encoding="utf-8"))
    found = {item["location"].partition("#")[0] for item in index["items"]}
    assert found == {str(path.relative_to(DOCS).with_suffix(".html")) for path in SITE} - {"changelog.html"}


def test_no_page_loads_anything_from_another_host(site: Path) -> None:
    loads = r"""<(?:script|img|iframe|video)\b[^>]*\bsrc="?https?:|<link\b[^>]*\brel="?stylesheet"?[^>]*https?:|url\(https?:"""
    found = [
        path.name
        for path in site.rglob("*")
        if path.suffix in (".html", ".css") and re.search(loads, path.read_text(encoding="utf-8"))
    ]
    assert found == []
