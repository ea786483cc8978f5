"""The drawings that the README shows are those that are made of the files."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.harness import ROOT, process

README = 890.0  # px; of the column that GitHub shows a README in
PICTURES = sorted((ROOT / "docs/pictures").glob("graph_*.svg"))


def test_each_graph_of_the_tutorial_has_a_picture() -> None:
    graphs = sorted((ROOT / "graphs/tutorial").glob("*.yaml"))
    assert [path.stem for path in PICTURES] == [f"graph_{path.stem}" for path in graphs]


@pytest.mark.parametrize("picture", PICTURES, ids=lambda picture: picture.stem)
def test_a_picture_is_byte_for_byte_what_its_command_makes(picture: Path, tmp_path: Path) -> None:
    name = f"tutorial/{picture.stem.removeprefix('graph_')}"
    result = process("show", name, "--svg", str(tmp_path / "made.svg"), env={"PYTHONHASHSEED": "7"})
    assert result.code == 0, result.err
    assert (tmp_path / "made.svg").read_bytes() == picture.read_bytes()


def test_at_the_width_of_a_readme_no_label_is_smaller_than_nine_pixels() -> None:
    for picture in PICTURES:
        text = picture.read_text(encoding="utf-8")
        width = float(re.search(r'width="([\d.]+)"', text)[1])  # type: ignore[index]
        sizes = [float(size) for size in re.findall(r"font-size: ([\d.]+)px", text)]
        assert min(sizes) * min(1.0, README / width) >= 9.0
