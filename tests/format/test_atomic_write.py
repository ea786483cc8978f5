"""Files that appear only when they are complete."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from graphengine.format.atomic_write import write_together
from graphengine.format.files import shipped


@pytest.fixture
def umask() -> Iterator[None]:
    before = os.umask(0o027)
    yield
    os.umask(before)


def test_files_are_created_and_replace_existing_files(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("before", encoding="utf-8")
    write_together({tmp_path / "a": b"1", tmp_path / "b": b"2"})
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"1", "b": b"2"}


@pytest.mark.parametrize(
    ("hindrance", "make", "reason"),
    [("b", Path.mkdir, "Is a directory"), ("b", os.mkfifo, "not a regular file"), ("b", Path.touch, "Not a directory")],
)
def test_if_one_file_cannot_be_written_no_file_changes(
    tmp_path: Path, hindrance: str, make: Callable[[Path], None], reason: str
) -> None:
    make(tmp_path / hindrance)
    (tmp_path / "a").write_text("before", encoding="utf-8")
    target = tmp_path / ("b/c" if make is Path.touch else "b")
    with pytest.raises(OSError, match=reason) as error:
        write_together({tmp_path / "a": b"1", target: b"2"})
    assert error.value.filename == str(target)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(["a", hindrance])
    assert (tmp_path / "a").read_text(encoding="utf-8") == "before"


def test_missing_folders_are_created(tmp_path: Path) -> None:
    write_together({tmp_path / "some/where/a": b"1"})
    assert (tmp_path / "some/where/a").read_bytes() == b"1"


def test_a_link_is_replaced_and_its_target_unchanged(tmp_path: Path) -> None:
    victim, target = tmp_path / "victim", tmp_path / "folder/x.svg"
    victim.write_text("mine", encoding="utf-8")
    target.parent.mkdir()
    for planted in (target, target.with_name(".x.svg.part")):
        planted.symlink_to(victim)
    write_together({target: b"drawing"})
    assert (victim.read_text(encoding="utf-8"), target.read_bytes()) == ("mine", b"drawing")
    assert not target.is_symlink()


def test_the_temporary_file_has_a_random_name_and_is_flushed_before_the_rename(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names: list[str] = []
    on_disk: list[int] = []
    replace, fsync = os.replace, os.fsync

    def synchronise(file: int) -> None:
        fsync(file)
        on_disk.append(os.fstat(file).st_size)

    def rename(part: Path, path: Path) -> None:
        names.append(part.name)
        assert on_disk == [9] * len(names)
        replace(part, path)

    monkeypatch.setattr(os, "fsync", synchronise)
    monkeypatch.setattr(os, "replace", rename)
    for _ in range(3):
        write_together({tmp_path / "a": b"nine byte"})
    assert len(set(names)) == 3


@pytest.mark.usefixtures("umask")
def test_a_new_file_has_the_mode_of_the_umask_and_a_replaced_file_keeps_its_mode(tmp_path: Path) -> None:
    old = tmp_path / "old"
    old.touch(mode=0o600)
    old.chmod(0o604)
    write_together({tmp_path / "new": b"1", old: b"2"})
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert modes == {"new": 0o640, "old": 0o604}


def test_no_other_module_writes_files() -> None:
    writing = re.compile(r"write_text\(|write_bytes\(|(?<!fd)open\(.*[\"'][wax]b?\+?[\"']|NamedTemporary|mkstemp")
    package = shipped() / "graphengine"
    writers = (path for path in package.rglob("*.py") if writing.search(path.read_text("utf-8")))
    found = {str(path.relative_to(package)) for path in writers}
    # These write to a new folder of their own, or to files that grow during a run.
    temporary = {"api/expectations/bag_file.py", "api/value_table.py", "recording/sources.py"}
    growing = {"experiments/programs.py", "experiments/result_rows.py", "recording/writer.py"}
    created = {"view/kept_token.py"}  # a new file that only its user can read
    assert found == {"format/atomic_write.py", *temporary, *growing, *created}
