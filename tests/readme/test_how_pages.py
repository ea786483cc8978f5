"""What the pages of docs/how show: each command prints the output below it, and each drawing is what its command makes."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.harness import ROOT, Graphrun

HOW = ROOT / "docs/how"
SHOWN = re.compile(r"^```sh\ngraphrun ([^\n]+)\n```\n\n```console\n(.*?)^```", re.MULTILINE | re.DOTALL)
WRITTEN = re.compile(r'^```yaml title="([^"]+)"\n(.*?)^```', re.MULTILINE | re.DOTALL)
PAGES = {path.stem: path.read_text(encoding="utf-8") for path in sorted(HOW.glob("*.md"))}
OUTPUTS = [(name, *found) for name, text in PAGES.items() for found in SHOWN.findall(text)]
GRAPHS = sorted(path.stem for path in (HOW / "graphs").glob("*.yaml"))


@pytest.mark.parametrize(("page", "command", "output"), OUTPUTS, ids=[shown[1] for shown in OUTPUTS])
def test_a_command_prints_what_stands_below_it(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str, command: str, output: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").symlink_to(ROOT / "docs")
    for name, text in WRITTEN.findall(PAGES[page]):
        (tmp_path / name).write_text(text, encoding="utf-8")
    for record in re.findall(r"^(graphrun run .* --record .*)$", PAGES[page], re.MULTILINE):
        graphrun(*shlex.split(record)[1:], "--transport", "memory", code=0)
    result = graphrun(*shlex.split(command), code=0)
    assert output in result.out + re.sub(r"^(?!info: ).*\n", "", result.err, flags=re.MULTILINE)


def test_a_mistake_is_printed_as_the_page_says(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = PAGES["file_to_code"]
    (shown,) = re.findall(r"^```console\n(branch\.yaml:.*?)^```", page, re.MULTILINE | re.DOTALL)
    ((name, text),) = WRITTEN.findall(page)
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_text(text.replace("Branch.execTrue ->", "Branch.execWhenTrue ->"), encoding="utf-8")
    graphrun("check", name, code=1, out=shown)
    assert text == (HOW / "graphs" / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("name", GRAPHS)
def test_the_drawing_of_a_rule_is_that_of_its_graph(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.chdir(ROOT)
    graphrun("show", f"docs/how/graphs/{name}.yaml", "--svg", str(tmp_path / "made.svg"), code=0)
    made = (tmp_path / "made.svg").read_text(encoding="utf-8")
    assert made == (ROOT / f"docs/pictures/rule_{name}.svg").read_text(encoding="utf-8")
    assert f"rule_{name}.svg" in PAGES["rules"]


def test_the_first_graph_is_drawn_as_its_page_shows_it(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (ROOT / "docs/start/first_graph.md").read_text(encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    name, text = WRITTEN.findall(page)[0]
    (tmp_path / name).write_text(text, encoding="utf-8")
    graphrun("show", name, "--svg", "circle.svg", code=0)
    assert (tmp_path / "circle.svg").read_bytes() == (ROOT / "docs/pictures/circle.svg").read_bytes()


@pytest.mark.parametrize("rule", range(1, 16))
def test_the_page_of_the_rules_has_each_rule(rule: int) -> None:
    assert re.search(rf"^## R{rule} \w", PAGES["rules"], re.MULTILINE)
