"""The page: one file that asks nobody, runs one script, and tells what it tells by keyboard too."""

from __future__ import annotations

import base64
import hashlib
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.cli.harness import ROOT
from tests.drawing.conftest import Draw

GRAPH = "graph: mine\nnodes:\n  Tick: OnPlaybackTick\n"
EVIL = '"</script><script>alert(1)</script>"'


class Page(HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.inside: dict[str, list[str]] = {"script": [], "style": []}
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attributes)))
        if tag in self.inside:
            self.inside[tag].append("")

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1][0] in self.inside and self.inside[self.tags[-1][0]]:
            self.inside[self.tags[-1][0]][-1] += data

    def handle_endtag(self, tag: str) -> None:
        self.tags.append((f"/{tag}", {}))


def policy(page: Page) -> dict[str, list[str]]:
    (content,) = [at["content"] for tag, at in page.tags if tag == "meta" and "http-equiv" in at]
    parts = [part.split() for part in (content or "").split(";")]
    return {name: values for name, *values in parts}


def digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def test_the_policy_of_the_page_allows_only_its_script_and_styles(drawn: Draw) -> None:
    page = Page(drawn(f"{GRAPH}  Odd: {{type: {EVIL}, doc: {EVIL}}}\n", html=True))
    rules = policy(page)
    assert rules["default-src"] == ["'none'"]
    assert rules["script-src"] == [digest(script) for script in page.inside["script"]]
    assert sorted(rules["style-src"]) == sorted(digest(style) for style in page.inside["style"])
    assert len(page.inside["script"]) == 1
    for tag, attributes in page.tags:
        assert not {"src", "href", "style", "action"} & attributes.keys(), tag
        assert not any(name.startswith("on") for name in attributes), tag


def test_what_a_stranger_writes_is_text_in_it(drawn: Draw) -> None:
    text = drawn(f"{GRAPH}  Odd: {{type: {EVIL}}}\n", html=True)
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text


def test_the_page_contains_no_address_except_the_svg_namespace(drawn: Draw) -> None:
    text = drawn((ROOT / "graphs/tutorial/joint_states.yaml").read_text(encoding="utf-8"), html=True)
    assert set(re.findall(r"\w+://[^\s\"'<]+", text)) == {"http://www.w3.org/2000/svg"}
    assert re.search(r"(url\(|@import)", text) is None


def test_the_page_contains_the_drawing_of_the_svg(drawn: Draw) -> None:
    assert drawn(GRAPH) in drawn(GRAPH, html=True)


@pytest.mark.skipif(shutil.which("node") is None, reason="node reads the script")
def test_the_script_of_the_page_is_javascript(drawn: Draw, tmp_path: Path) -> None:
    (tmp_path / "page.js").write_text(Page(drawn(GRAPH, html=True)).inside["script"][0], encoding="utf-8")
    done = subprocess.run(["node", "--check", "page.js"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
