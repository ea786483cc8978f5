"""Commands and options in messages can be copied into a shell."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

import graphengine
from graphengine.format.wording import quoted

PACKAGE = Path(graphengine.__file__).parent
FROM_FILES = r"--(?:allow|assume|macro|model|without|package-path)|\bcd|graphrun (?:ctl|import|import-robot) [a-z-]*"
UNQUOTED = re.compile(rf"""f["'].*(?:{FROM_FILES}) \{{(?!quoted\()""")
OPTIONS = re.compile(r"raise UsageError\(f\"--")  # the option as the user wrote it


@pytest.mark.parametrize("word", ["plain", "mein röbot 1", "it's", "$(ls)", "a;b", "-x", ""])
def test_a_quoted_word_is_one_word_for_a_shell(word: str) -> None:
    assert shlex.split(quoted(word)) == [word]


def test_a_quoted_word_has_no_control_characters() -> None:
    assert quoted("\x1b[31mred\n").isprintable()


def test_names_of_files_and_their_parts_are_quoted_in_commands() -> None:
    lines = [
        f"{path.relative_to(PACKAGE)}: {line.strip()}"
        for path in PACKAGE.rglob("*.py")
        for line in path.read_text(encoding="utf-8").splitlines()
        if UNQUOTED.search(line) and not OPTIONS.search(line)
    ]
    assert lines == []
