"""The files of a run under machine-independent names, and their extraction to another folder.

Names with `shipped/` are files of this package, names with `installed/` are files of ROS packages in sourced workspaces, and
names with `messages/` are definitions of message types. All other files have names with `project/`, relative to their common
parent folder, so that references between files stay valid. `reloaded/N/` contains the changed files of reload N.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path, PurePosixPath
from types import MappingProxyType

from graphengine.format.errors import RecordingError
from graphengine.format.files import Files
from graphengine.format.wording import shown
from graphengine.messages.definitions import Definitions
from graphengine.scene.loaded_scene import Options

SHIPPED, INSTALLED, MESSAGES, PROJECT, RELOADED = PLACES = ("shipped", "installed", "messages", "project", "reloaded")
MAX_BYTES = 2_000_000_000
"""Maximum size of all files of a recording together, bytes."""
MAX_FILES = 20_000
"""Maximum number of files in a recording."""
MAX_PARTS = 100
"""Maximum number of path elements in a file name."""
_MEDIA_TYPES: Mapping[str, str] = MappingProxyType(
    {".yaml": "application/yaml", ".yml": "application/yaml"}
    | dict.fromkeys((".xml", ".urdf", ".xacro", ".mjcf"), "application/xml")
)


class SourceNames:
    """Assigns names to the files that a run reads.

    Args:
        files: record of the files that were read.
    """

    def __init__(self, files: Files) -> None:
        self._installed = files.installed
        self._base = files.base
        apart = (*files.installed, files.base)
        folders = [*files.roots, *(_real(path).parent for path in files.used)]
        own = [folder for folder in folders if not any(folder.is_relative_to(other) for other in apart)]
        self._common = Path(os.path.commonpath(own)) if own else None

    def name(self, path: Path) -> str:
        """Return the name of the file with this absolute path; outside all known folders, `project/` and the file name."""
        return self._name(path).encode("utf-8", "replace").decode()  # replaces bytes that are not UTF-8

    def _name(self, path: Path) -> str:
        for folder in self._installed:
            if path.is_relative_to(folder):
                return f"{INSTALLED}/{path.relative_to(folder).as_posix()}"
        real = _real(path)
        if real.is_relative_to(self._base):
            return f"{SHIPPED}/{real.relative_to(self._base).as_posix()}"
        if self._common is not None and real.is_relative_to(self._common):
            return f"{PROJECT}/{real.relative_to(self._common.parent).as_posix()}"
        return f"{PROJECT}/{path.name}"


def sources(files: Files, definitions: Definitions, names: SourceNames) -> dict[str, Path]:
    """Return a dict from names to paths of all files that a run reads, also message definitions."""
    used = {names.name(path): path for path in files.used}
    return used | {f"{MESSAGES}/{name}{path.suffix}": path for name, path in definitions.files.items()}


def read_again(files: Files, paths: Mapping[str, Path]) -> dict[str, bytes]:
    """Return the content of each file by its name; `paths` is a dict from names to paths.

    Raises:
        RecordingError: a file cannot be read.
    """
    try:
        return {name: files.content(path) for name, path in paths.items()}
    except OSError as error:
        raise RecordingError(f"{error.filename}: cannot be read again: {error.strerror}") from None


def media_type(name: str) -> str:
    """Return the media type for a file name, from the suffix."""
    return _MEDIA_TYPES.get(PurePosixPath(name).suffix.lower(), "application/octet-stream")


class Workspace:
    """A folder to which the files of a recording are extracted; no file is written outside it.

    Args:
        folder: empty folder that nothing else writes to.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder.resolve()
        self._bytes = self._files = 0
        self._originals: dict[str, Path | None] = {}
        """Path of the copy of each exchanged file's original version; None if the file did not exist originally."""
        self._copied: dict[Path, int] = {}
        """Size of each copy, bytes."""
        self._copied_bytes = 0
        self.exchanged: Mapping[str, str | None] = {}
        """The argument of the last call of `exchange`."""
        for place in PLACES:
            Path(self.folder, place).mkdir()

    def options(self, options: Options, scene: str = "") -> Options:
        """Return load options for the files of the recording; the options permit reading files only in this folder.

        Args:
            options: all other options.
            scene: name of the scene into which a single graph is loaded; empty if there is none.
        """
        return replace(
            options,
            allowed=[self.folder / PROJECT],
            installed=[self.folder / INSTALLED],
            shipped=self.folder / SHIPPED,
            message_paths=[self.folder / MESSAGES],
            scene=self.path(scene) if scene else None,
            near=None,
            recorded=True,
        )

    def path(self, name: str) -> Path:
        """Return the path of the recorded file with this name in the workspace; the file need not exist.

        Raises:
            RecordingError: no recorder writes such a name.
        """
        parts = PurePosixPath(name).parts
        known = 1 < len(parts) <= MAX_PARTS and parts[0] in PLACES and ".." not in parts
        if not known or "\0" in name or any("\ud800" <= letter <= "\udfff" for letter in name):
            raise RecordingError(f"{shown(name)} is not a legal name for a file of a recording")
        return self.folder.joinpath(*parts)

    def exchange(self, files: Mapping[str, str | None]) -> None:
        """Replace files with the versions that a reload read; all other files get their original versions again.

        Args:
            files: a dict from each file to replace to the name of its new version; None deletes the file.

        Raises:
            RecordingError: a name is not legal, a file is missing, or the copies are too many or too large.
        """
        self.exchanged = files
        for name in files:
            if name not in self._originals:
                kept = self.path(f"{RELOADED}/0/{name}")
                self._originals[name] = kept if self._copy(self.path(name), kept) else None
        for name, original in self._originals.items():
            other = files.get(name)
            source = self.path(other) if other is not None else original if name not in files else None
            if source is None:
                self._remove(self.path(name))
            elif not self._copy(source, self.path(name)):
                raise RecordingError(f"the recording lacks the file {other!r}, which a reload read")

    def _remove(self, path: Path) -> None:
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise RecordingError(f"the recording's file {path.name!r} cannot be removed: {error.strerror}") from None
        self._copied_bytes -= self._copied.pop(path, 0)

    def _copy(self, source: Path, target: Path) -> bool:
        """Copy a file to a new inode, so that a reload detects the change. Return whether `source` exists."""
        try:
            size = source.stat().st_size
            self._copied_bytes += size - self._copied.get(target, 0)
            self._copied[target] = size
            self._check_size(self._copied_bytes, len(self._copied))
            target.parent.mkdir(parents=True, exist_ok=True)
            coming = target.with_name(f"{target.name}.coming")
            shutil.copyfile(source, coming)
            coming.replace(target)
        except FileNotFoundError:
            return False
        except OSError as error:
            raise RecordingError(f"the recording's file {source.name!r} cannot be replaced: {error.strerror}") from None
        return True

    def add(self, name: str, data: bytes) -> None:
        """Write a file of the recording to the folder.

        Raises:
            RecordingError: the name is not legal, or the files are too many or too large.
        """
        self._bytes += len(data)
        self._files += 1
        self._check_size(self._bytes, self._files)
        path = self.path(name)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        except OSError as error:
            raise RecordingError(f"the recording's file {name!r} cannot be extracted: {error.strerror}") from None

    @staticmethod
    def _check_size(size: int, files: int) -> None:
        if size > MAX_BYTES or files > MAX_FILES:
            limit = f"more than {MAX_FILES} files, or they are larger than {MAX_BYTES // 10**9} GB"
            raise RecordingError(f"the recording has {limit}")


def _real(path: Path) -> Path:
    """Return a path with symbolic links resolved in its folders, but not in the file name."""
    return path.parent.resolve() / path.name
