"""CHANGELOG.md says in one line what changed, and the version of the package has a section with its day."""

from __future__ import annotations

import datetime
import re

from graphengine.format.version import __version__
from tests.cli.harness import ROOT

CHANGELOG = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
SECTIONS = ["Added", "Changed", "Fixed", "Security", "Migration"]
LONGEST = 150
"""Maximum number of characters of an entry."""


def releases() -> dict[str, str]:
    """Return the text of each release by its heading."""
    _, *parts = re.split(r"^## ", CHANGELOG, flags=re.MULTILINE)
    return {part.partition("\n")[0]: part.partition("\n")[2] for part in parts}


def test_the_version_of_the_package_is_the_newest_release_and_has_a_day() -> None:
    unreleased, newest, *_ = releases()
    assert unreleased == "[Unreleased]"
    version, day = re.findall(r"^\[(\S+)\] - (\S+)$", newest)[0]
    assert version == __version__
    assert datetime.date.fromisoformat(day) <= datetime.datetime.now(datetime.UTC).date()


def test_each_release_has_the_known_sections_in_one_order() -> None:
    for heading, text in releases().items():
        found = re.findall(r"^### (.*)$", text, re.MULTILINE)
        assert found == [name for name in SECTIONS if name in found], heading


def test_every_entry_is_one_short_line() -> None:
    lines = CHANGELOG.splitlines()
    assert [line for line in lines if line.startswith("  ")] == []
    assert [line for line in lines if line.startswith("- ") and len(line) > LONGEST] == []
    entries = [line for line in lines if line.startswith("- ")]
    assert len(entries) > 300
    assert len(set(entries)) == len(entries)
    assert [line for line in entries if not line.endswith(".")] == []
