"""`graphrun explain`: each code has an explanation, whose example produces the finding and whose remedy removes it."""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from graphengine.cli.explain import FOLDER, RELATED, explanation, groups
from graphengine.format.diagnostics import CODES, Finding
from graphengine.sandbox.borders import BORDERS
from tests.cli.harness import ROOT, Graphrun, Result, live, process
from tests.docs.generate import diagnostics

RECORDINGS = Path(__file__).parent / "recordings"
WITHOUT_EDIT = {"G101", "N104", "N302", "W109", "W206", "W301"}
"""Codes whose remedy is not an edit of a file."""


def lose_landlock(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BORDERS, "Landlock", (lambda: False, BORDERS["Landlock"][1]))


def save_as_latin1(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (folder / "clock.yaml").read_text(encoding="utf-8")
    (folder / "clock.yaml").write_text(text, encoding="latin-1")


def add_old_recording(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copy(RECORDINGS / "limits.mcap", folder / "old_run.mcap")


CONDITIONS: dict[str, Callable[[Path, pytest.MonkeyPatch], None]] = {
    "G101": save_as_latin1,
    "W109": add_old_recording,
    "W206": lose_landlock,
}
"""What the text of an example says about its files or its machine, by code."""


def blocks(text: str, language: str) -> list[tuple[str, str]]:
    """Title and text of each block in a language."""
    return re.findall(rf'^```{language}(?: title="([^"]+)")?\n(.*?)^```$', text, re.MULTILINE | re.DOTALL)


def parts(code: str) -> tuple[str, str, str]:
    headings = ("Example", "Remedy", "Related")
    assert tuple(re.findall(r"^## (.*)$", explanation(code), re.MULTILINE)) == headings
    cause, example, remedy, _ = re.split(r"^## .*$", explanation(code), flags=re.MULTILINE)
    return cause, example, remedy


def write_files(code: str, folder: Path) -> list[Path]:
    files = [(title, text) for title, text in blocks(parts(code)[1], r"\w+") if title]
    for title, text in files:
        (folder / title).write_text(text, encoding="utf-8")
    return [folder / title for title, _ in files]


def edit_files(code: str, files: list[Path]) -> int:
    """Apply the remedy's diffs; a diff without a title is for the first file."""
    diffs = blocks(parts(code)[2], "diff")
    for title, diff in diffs:
        path = next(path for path in files if path.name == (title or files[0].name))
        text = path.read_text(encoding="utf-8")
        old = "".join(f"{line[1:]}\n" for line in diff.splitlines() if line[:1] != "+")
        new = "".join(f"{line[1:]}\n" for line in diff.splitlines() if line[:1] != "-")
        assert text.count(old) == 1, f"the lines of the diff occur once in {path.name}:\n{old}"
        path.write_text(text.replace(old, new), encoding="utf-8")
    return len(diffs)


def run_example(code: str, graphrun: Graphrun) -> Result:
    ((_, commands),) = blocks(parts(code)[1], "sh")
    (command,) = commands.splitlines()
    return graphrun(*shlex.split(command)[1:])


def reports(code: str, result: Result) -> bool:
    return f"{Finding(code, '').severity} {code}: " in result.out + result.err


@pytest.mark.parametrize("code", CODES)
def test_the_example_produces_the_finding_and_the_remedy_removes_it(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str
) -> None:
    monkeypatch.chdir(tmp_path)
    files = write_files(code, tmp_path)
    if code in CONDITIONS:
        CONDITIONS[code](tmp_path, monkeypatch)
    result = run_example(code, graphrun)
    assert reports(code, result), result
    printed = " ".join((result.out + result.err).split())
    for _, shown in blocks(parts(code)[1], "console"):
        for chunk in shown.split("\n…\n"):
            assert " ".join(chunk.split()) in printed
    assert bool(edit_files(code, files)) == (code not in WITHOUT_EDIT)
    if code not in WITHOUT_EDIT:
        assert not reports(code, run_example(code, graphrun))


def test_each_code_has_one_explanation_and_belongs_to_one_group() -> None:
    assert sorted(path.name for path in FOLDER.iterdir()) == sorted(f"{code}.md" for code in CODES)
    assert sorted(code for _, codes in groups() for code in codes) == sorted(CODES)


@pytest.mark.parametrize("code", CODES)
def test_an_explanation_names_only_codes_that_exist_and_fits_80_columns(graphrun: Graphrun, code: str) -> None:
    assert set(re.findall(r"\b[GSWN]\d{3}\b", explanation(code))) - {code} <= set(CODES)
    result = graphrun("explain", code, code=0, err="")
    assert result.lines[0] == Finding(code, CODES[code]).render()
    assert [line for line in result.lines if len(line) > 80] == []
    related = RELATED.findall(explanation(code))
    assert related
    assert code not in related
    assert result.lines[-len(related) :] == [f"- {other}: {CODES[other]}" for other in related]


def test_several_codes_are_explained_in_any_case_each_once(graphrun: Graphrun) -> None:
    result = graphrun("explain", "g204", "W108", "G204", code=0, err="")
    titles = [line for line in result.lines if re.match(r"(error|warning|note) [GSWN]\d{3}: ", line)]
    assert titles == ["error G204: unknown port", "warning W108: wire written twice"]


def test_without_a_code_all_codes_are_listed_by_group(graphrun: Graphrun) -> None:
    lines = graphrun("explain", code=0, err="").lines
    assert [line.split()[0] for line in lines if line.startswith("  ")] == list(CODES)
    assert "  G204  unknown port" in lines
    assert lines[0] == "Errors: reading a file"


def test_an_unknown_code_gets_a_suggestion(graphrun: Graphrun) -> None:
    said = "graphrun explain: no code 'W1088'\n  did you mean 'W108'?\n  `graphrun explain` lists all codes\n"
    graphrun("explain", "W1088", code=2, out="", err=said)
    assert "codes: G101, G102, " in graphrun("explain", "xyzzy", code=2, out="").err


def test_a_terminal_gets_colours_and_a_pipe_the_same_text_without(tmp_path: Path) -> None:
    with live("explain", "W108", cwd=tmp_path, columns=80, out=True) as running:
        running.hear(lambda said: False)
    said = running.said.replace("\r", "")
    assert said.startswith("\x1b[1;33mwarning W108\x1b[0m: wire written twice\n")
    assert "\x1b[1mRemedy\x1b[0m\n" in said
    assert "    \x1b[31m-  - Tick.tick -> Clock.execIn\x1b[0m\n" in said
    assert re.sub(r"\x1b\[[0-9;]*m", "", said) == process("explain", "W108", cwd=tmp_path).out


def test_check_names_the_command_that_explains_the_gravest_finding(
    graphrun: Graphrun, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "graph: g\nnodes: {Tick: OnPlaybackTick, Idle: PublishClock}\n"
    Path("warned.yaml").write_text(text, encoding="utf-8")
    Path("broken.yaml").write_text(f"{text}connections: [Tick.tack -> Idle.execIn]\n", encoding="utf-8")
    Path("fine.yaml").write_text("graph: g\nnodes: {Tick: OnPlaybackTick}\n", encoding="utf-8")
    assert graphrun("check", "warned.yaml").lines[-2] == "explain a code: graphrun explain W101"
    assert graphrun("check", "warned.yaml", "broken.yaml").lines[-2] == "explain a code: graphrun explain G204"
    assert "explain" not in graphrun("check", "fine.yaml").out
    for form in ("json", "github"):
        assert "graphrun explain" not in graphrun("check", "broken.yaml", "--format", form).out


def test_the_page_in_the_documentation_has_all_explanations_and_its_links_lead_to_them() -> None:
    ((name, page),) = diagnostics.pages()
    kept = (ROOT / "docs/reference" / name).read_text(encoding="utf-8")
    assert kept == f"<!-- Written by `python -m tests.docs.generate`. -->\n\n{page}"
    headings = [line[4:] for line in page.splitlines() if line.startswith("### ")]
    assert headings == [f"{code}: {CODES[code]}" for _, codes in groups() for code in codes]
    anchors = {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}
    assert set(re.findall(r"\]\(#([^)]+)\)", page)) == anchors
