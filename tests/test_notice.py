"""NOTICE names the origin and the licence of all data that the repository and its packages contain."""

from __future__ import annotations

import re
import tomllib
from fnmatch import fnmatch
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from graphengine.format.version import __version__

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FOLDERS = ("docs", "examples", "graphengine", "graphs", "nodes", "ros", "scenes", "tests")
LICENCES = {
    "Apache-2.0": "Apache License",
    "BSD-3-Clause": "Redistributions in binary form must",
    "MIT": "Permission is hereby granted, free of charge",
}
"""Words of the text of each licence."""
OWN_WORDS = {".py", ".pyi", ".md", ".sh", ".toml", ".cfg"}
"""Code, prose and configuration, which the project's own authors write."""
MADE_BY_TOOLS = {"__pycache__", ".pytest_cache", ".mypy_cache", ".ruff_cache", ".hypothesis", "build"}


class Entry(NamedTuple):
    patterns: list[str]
    origin: str
    licence: str


def entries() -> list[Entry]:
    """Return the entries of NOTICE."""
    text = (ROOT / "NOTICE").read_text(encoding="utf-8")
    found = re.findall(r"^Files: (.*?)^From: (.*?)^Licence: (.*?)$", text, re.MULTILINE | re.DOTALL)
    return [Entry(patterns.split(), " ".join(origin.split()), licence) for patterns, origin, licence in found]


def data_files() -> list[str]:
    """Return the paths of all files in the folders of the repository that are neither code nor prose."""
    found = []
    for folder in FOLDERS:
        for path in (ROOT / folder).rglob("*"):
            place = path.relative_to(ROOT)
            skipped = MADE_BY_TOOLS.intersection(place.parts) or place.parts[:2] == ("graphengine", "nodes")
            generated = any(part.endswith(".egg-info") for part in place.parts)
            if path.is_file() and path.suffix not in OWN_WORDS and not skipped and not generated:
                found.append(place.as_posix())
    return found


DATA = data_files()


def test_every_data_file_has_an_entry() -> None:
    patterns = [pattern for entry in entries() for pattern in entry.patterns]
    assert len(DATA) > 300
    assert [path for path in DATA if not any(fnmatch(path, pattern) for pattern in patterns)] == []


@pytest.mark.parametrize("entry", entries(), ids=lambda entry: entry.patterns[0])
def test_every_entry_has_files_an_origin_and_a_licence_whose_text_is_in_the_packages(entry: Entry) -> None:
    assert [pattern for pattern in entry.patterns if not any(fnmatch(path, pattern) for path in DATA)] == []
    assert entry.origin
    identifier, text = re.findall(r"^([\w.-]+), ([\w./]+)", entry.licence)[0]
    assert (text == "LICENSE") == (identifier == "Apache-2.0")
    assert any(fnmatch(text, pattern) for pattern in PROJECT["license-files"])
    words = " ".join((ROOT / text).read_text(encoding="utf-8").split())
    assert LICENCES[identifier] in words


def test_each_licence_of_an_entry_is_in_the_licence_of_the_package() -> None:
    used = {entry.licence.partition(",")[0] for entry in entries()}
    assert PROJECT["license"] == " AND ".join(sorted(used))
    named = {entry.licence.split(", ")[1] for entry in entries()}
    assert {path.name for path in (ROOT / "licenses").iterdir()} == {Path(name).name for name in named - {"LICENSE"}}


def test_the_citation_has_the_version_and_the_date_of_the_newest_changelog_entry() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert str(citation["version"]) == __version__
    assert f"\n## [{__version__}] - {citation['date-released']}\n" in changelog
    assert citation["license"] in PROJECT["license"].split(" AND ")
