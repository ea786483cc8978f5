"""The scripts of the HTML file: up to date with their sources, small, and without text that ends their element."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

import graphengine

FOLDER = Path(graphengine.__file__).parent / "view/html"
SOURCES = sorted([*(FOLDER / "source").glob("*.js"), FOLDER / "source/package.json"])
LICENCES = Path(__file__).parents[3] / "licenses"


def text_of(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


def test_the_bundle_is_made_from_the_sources() -> None:
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()
    assert text_of("bundle.js").startswith(f"/*! Sources: {digest}\n"), "run graphengine/view/html/source/bundle.sh"


def test_notice_lists_the_bundled_versions_and_the_bundles_contain_the_licences() -> None:
    versions = json.loads(text_of("source/package.json"))["dependencies"]
    notice = (LICENCES.parent / "NOTICE").read_text(encoding="utf-8")
    assert f"three.js {versions['three']} (" in notice
    assert f"uPlot {versions['uplot']} (" in notice
    assert (LICENCES / "three.txt").read_text(encoding="utf-8") in text_of("bundle.js")
    assert (LICENCES / "uplot.txt").read_text(encoding="utf-8") in text_of("uplot.js")


def test_the_scripts_cannot_end_their_element_and_name_no_address_to_load() -> None:
    scripts = text_of("uplot.js") + text_of("bundle.js")
    assert re.findall(r"</script|<!--|\beval\(|new Function\(|import\(", scripts) == []


def test_the_scripts_of_the_page_stay_small() -> None:
    own = [line for path in SOURCES if path.suffix == ".js" for line in path.read_text(encoding="utf-8").splitlines()]
    assert len(own) <= 500
    assert (FOLDER / "bundle.js").stat().st_size < 700_000
