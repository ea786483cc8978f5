"""Files that are written whole or not at all."""

from __future__ import annotations

from pathlib import Path

import pytest

from graphengine.output import write_together


def test_files_appear_and_replace_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("before", encoding="utf-8")
    write_together({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"1", "b": b"2"}


@pytest.mark.parametrize("hindrance", ["b", ".b.part"])
def test_when_one_cannot_be_written_all_is_as_it_was_and_it_is_told(tmp_path: Path, hindrance: str) -> None:
    (tmp_path / hindrance).mkdir()
    (tmp_path / "a").write_text("before", encoding="utf-8")
    with pytest.raises(OSError, match="Is a directory") as error:
        write_together({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert error.value.filename == str(tmp_path / "b")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["a", hindrance])
    assert (tmp_path / "a").read_text(encoding="utf-8") == "before"


def test_a_folder_that_is_not_there_is_told_with_the_file(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file or directory") as error:
        write_together({tmp_path / "no/a": b"1"})
    assert error.value.filename == str(tmp_path / "no/a")
