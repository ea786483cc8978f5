"""Answers of confined processes: what they may hold."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from graphengine.format.files import Files
from graphengine.sandbox import untrusted
from graphengine.sandbox.confinement import ProcessError
from graphengine.sandbox.untrusted import Sources, read


@dataclass
class Answer:
    value: Any


@pytest.mark.parametrize(("number", "kind"), [(-(2**63) - 1, float), (-(2**63), int), (2**64 - 1, int), (2**64, float)])
def test_a_whole_number_of_more_than_64_bits_becomes_a_float(number: int, kind: type[float]) -> None:
    value = read(b'{"value": %d}' % number, Answer, 100).value
    assert (type(value), value) == (kind, kind(number))


def test_source_lines_of_all_files_are_quoted_up_to_a_total_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(untrusted, "MAX_SOURCES", 10)
    names = [str(tmp_path / name) for name in ("a", "b", "c")]
    for name in names:
        Path(name).write_text("one\ntwo", encoding="utf-8")
    sources = Sources(Files((tmp_path,)))
    for _ in range(2):  # each file is read once
        found = [sources.span(name, 1, 1, 1).source.lines for name in names]
        assert found == [("one", "two"), ("one",), ("",)]


@pytest.mark.parametrize(
    "forged",
    [
        b"[" + b",".join([b"[]"] * 1_900_000) + b"]",
        b"[" + b",".join([b"[[[[[[[[]]]]]]]]"] * 237_500) + b"]",
        b"[" * 1_900_000 + b"]" * 1_900_000,
        b"[" + b",".join([b'{"a":[]}'] * 950_000) + b"]",
    ],
    ids=["flat", "by eights", "deep", "objects"],
)
def test_an_answer_of_two_million_lists_is_refused_before_it_is_parsed(
    monkeypatch: pytest.MonkeyPatch, forged: bytes
) -> None:
    monkeypatch.setattr(json, "loads", lambda *_: pytest.fail("it was parsed"))
    with pytest.raises(ProcessError, match="sends a malformed answer"):
        read(b'{"value": %s}' % forged, Answer, 256_000_000)


def test_brackets_and_commas_in_the_strings_of_an_answer_are_not_counted() -> None:
    text = "[{,\\" * 2_000_000
    assert read(json.dumps({"value": text}).encode(), Answer, 256_000_000).value == text
