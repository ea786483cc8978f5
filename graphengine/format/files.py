"""Look-up of files that other files refer to, and the folders that may be read.

A reference is looked up beside the file that contains it, then among the included graphs and scenes. The file found must lie in
the folder of the file given by the user, among the included files, or in a folder that the user allowed, so an untrusted scene
cannot read other files.
"""

from __future__ import annotations

import contextlib
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.errors import UsageError
from graphengine.format.regular_files import open_regular
from graphengine.format.wording import did_you_mean


def shipped() -> Path:
    """Return the folder with the included `graphs/` and `scenes/`: the package's data in a wheel, otherwise the checkout."""
    package = Path(__file__).resolve().parents[1]
    data = package / "_data"
    return data if data.is_dir() else package.parent


Signature = tuple[int, ...] | None
"""State of a file that differs after every change of the file; None for a missing file."""


def signature(path: str | os.PathLike[str]) -> Signature:
    """Return mode, inode, size and times of the file or folder at a path, without opening it; None if there is none."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_mode, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


PACKAGE = "package://"
"""Prefix of a reference to a file in a ROS package of a sourced workspace."""
MAX_NAMED = 5
"""Maximum number of scene files to name for a folder."""
MAX_SEARCHED = 10_000
"""Number of bytes at the beginning of a file that are searched for its key `scene` or `graph`."""
_SCENE, _GRAPH = re.compile(rb"^scene\s*:", re.MULTILINE), re.compile(rb"^graph\s*:", re.MULTILINE)


class NotFoundError(Exception):
    """A file does not exist or may not be read. Arguments: message, then lines of help."""

    def __init__(self, message: str, *help: str) -> None:
        super().__init__(message)
        self.message = message
        self.help = help


@dataclass(frozen=True, slots=True)
class Files:
    """The folders that may be read, and a record of the files that were read or missing."""

    roots: tuple[Path, ...]
    near: Path | None = None
    """Working directory: messages show paths below it relative to it. None: paths are shown as found."""
    installed: tuple[Path, ...] = ()
    """Folders with the ROS packages that the user installed; they are also in `roots`."""
    base: Path = field(default_factory=shipped)
    """Folder with the included `graphs/` and `scenes/`."""
    used: dict[Path, Signature] = field(default_factory=dict, compare=False, repr=False)
    """State before reading of all files that the user gave or to which a reference pointed, by absolute path, in order."""
    sought: dict[Path, Signature] = field(default_factory=dict, compare=False, repr=False)
    """Absolute paths at which a reference found no regular file, with the state of a folder or pipe there."""

    @staticmethod
    def of(
        given: Path,
        allowed: Sequence[Path] = (),
        near: Path | None = None,
        installed: Sequence[Path] = (),
        base: Path | None = None,
    ) -> Files:
        """Return the folders that may be read for a file given by the user.

        Args:
            given: path of the file.
            allowed: further folders that the user allows to read.
            near: working directory, see `near` of the class.
            installed: folders with ROS packages that the user installed.
            base: folder with the included `graphs/` and `scenes/`; None: the package's.
        """
        base = base or shipped()
        roots = (base / "graphs", base / "scenes", *(path.resolve() for path in (*allowed, *installed)))
        near = near.resolve() if near else None
        return Files(roots, near, tuple(path.absolute() for path in installed), base).beside(given)

    def beside(self, given: Path) -> Files:
        """Return a copy that also permits the folder of `given`, an additional file that the user names."""
        self.note(given)
        return replace(self, roots=(given.resolve().parent, *self.roots))

    def note(self, path: Path) -> None:
        """Record that a file is about to be read."""
        place = Path(os.path.abspath(path))
        if place not in self.used:
            self.used[place] = signature(place)

    def note_missing(self, path: Path) -> None:
        """Record a path at which a reference was looked up and no file was found."""
        place = Path(os.path.abspath(path))
        self.sought[place] = signature(place)

    def include(self, other: Files) -> None:
        """Add the paths that another object recorded; paths recorded here keep their state."""
        for path, before in other.used.items():
            self.used.setdefault(path, before)
        for path, before in other.sought.items():
            self.sought.setdefault(path, before)

    def noted(self) -> dict[Path, Signature]:
        """Return all recorded paths, with the state of the file when it was recorded."""
        return self.sought | self.used

    def changed(self) -> set[Path]:
        """Return the recorded files that have since changed, appeared or disappeared."""
        return {path for path, before in self.noted().items() if signature(path) != before}

    def links(self) -> Iterator[Path]:
        """Yield the symbolic links in installed packages; their targets may be read wherever they are."""
        for top in self.installed:
            for folder, folders, names in os.walk(top):
                yield from (path for name in (*folders, *names) if (path := Path(folder, name)).is_symlink())

    def find(self, reference: str, folder: Path) -> Path:
        """Return the path of the file to which `reference`, written in a file in `folder`, refers.

        Raises:
            NotFoundError: the file does not exist, or lies outside the folders that may be read.
        """
        base = self.base
        places = [folder / reference, base / reference, base / "scenes" / reference, base / "graphs" / reference]
        for place in places:
            if os.path.isfile(place):  # False for illegal names, too
                if not self.may_read(place):
                    raise NotFoundError(
                        f"{reference!r} lies outside the folder of the file you gave",
                        f"allow it with --allow {place.resolve().parent}",
                    )
                self.note(place)
                return self.shown(place)
            if self.may_read(place):
                self.note_missing(place)
        looked = f"looked in {str(places[0].parent)!r}, and among the included graphs and scenes"
        raise NotFoundError(f"no file {reference!r}", self._near(reference, places), looked)

    def look_up(
        self, reference: str, folder: Path, findings: Findings, span: Span | None, owner: str = ""
    ) -> Path | None:
        """Return the path of the file to which a reference points; None after an error, which is added to `findings`.

        Args:
            reference: reference to the file, as in `find`.
            folder: folder of the file with the reference.
            findings: findings to add the error to.
            span: place of the reference.
            owner: text in front of the message, which says what the file is for.
        """
        try:
            return self.find(reference, folder)
        except NotFoundError as error:
            findings.add("S101", f"{owner}{error.message}", span, *error.help)
            return None

    def shown(self, path: Path) -> Path:
        """Return the path to show in messages: relative to the working directory for files below it."""
        if self.near is not None and path.resolve().is_relative_to(self.near):
            return path.resolve().relative_to(self.near)
        return path

    def may_read(self, path: Path) -> bool:
        """Return whether a file lies below one of the roots after links are resolved.

        Links in installed packages may lead anywhere, as `colcon build --symlink-install` makes such links.
        """
        if ".." not in path.parts and any(path.is_relative_to(folder) for folder in self.installed):
            return True
        try:
            resolved = path.resolve()
        except (OSError, RuntimeError, ValueError):  # an illegal file name, or a loop of links
            return False
        return any(resolved.is_relative_to(root) for root in self.roots)

    def _near(self, reference: str, places: Sequence[Path]) -> str:
        names: list[str] = []
        for place in places:
            if self.may_read(place.parent) and os.access(place.parent, os.R_OK) and os.path.isdir(place.parent):
                files = [name for name in os.listdir(place.parent) if os.path.isfile(place.parent / name)]
                names += [str(Path(reference).parent / name) for name in files]
        return did_you_mean(reference, names)


def find_given(name: str, folder: str) -> Path:
    """Return the file for a command-line argument: a path, or the name of an included file in `graphs` or `scenes`.

    In sourced ROS workspaces, `package://my_robot/scenes/hall.yaml` and `my_robot/scenes/hall.yaml` are files of a package.

    Raises:
        NotFoundError: no such file exists.
    """
    base = shipped()
    if name.startswith(PACKAGE):
        return _in_package(name)
    shares = (share / name for share in installed_packages())
    places = [Path(name), base / folder / name, base / folder / f"{name}.yaml", base / name, *shares]
    for place in places:
        if os.path.isfile(place):
            return place
    known = sorted(str(path.relative_to(base / folder).with_suffix("")) for path in (base / folder).rglob("*.yaml"))
    known = [name for name in known if name.partition("/")[0] not in ("robots", "sensors")]  # not run by themselves
    shipping = f"{folder} that ship: {', '.join(known)}" if known else ""
    raise NotFoundError(f"no file {name!r}", did_you_mean(name, known), shipping)


def _in_package(reference: str) -> Path:
    """Return the file for `package://PACKAGE/PATH`.

    Raises:
        NotFoundError: no sourced workspace has the package, or the package does not have the file.
    """
    package, _, path = reference.removeprefix(PACKAGE).partition("/")
    shares = installed_packages()
    folders = [share / package for share in shares if package and os.path.isdir(share / package)]
    for folder in folders:
        if os.path.isfile(folder / path):
            return folder / path
    if folders:
        raise NotFoundError(f"no file {path!r} in the package {package!r}", _beside(str(folders[0] / path)))
    known = {name for share in shares if os.path.isdir(share) for name in os.listdir(share)}
    remedy = did_you_mean(package, known) if known else "no ROS workspace is sourced: source install/setup.bash"
    raise NotFoundError(f"no package {package!r}", remedy)


def find_file(name: str) -> Path:
    """Return the file for an argument, as `find_given` does for scenes and graphs, by its shortest path.

    Raises:
        UsageError: no such file exists.
    """
    failures = []
    for folder in ("scenes", "graphs"):
        try:
            return Path(near(str(find_given(name, folder))))
        except NotFoundError as error:
            failures.append(error)
    if os.path.isdir(name) and (scenes := _scenes_in(Path(name))):
        raise UsageError(f"{name}: a folder, not a file\n  try {' or '.join(scenes)}")
    if os.path.exists(name):
        require_file(name)
    hints = [_beside(name), *(line for failure in failures for line in failure.help)]
    near_ones = [line for line in hints if line.startswith("did you mean")]
    raise UsageError("\n  ".join([failures[0].message, *dict.fromkeys(near_ones or filter(None, hints))]))


def require_file(path: str | Path) -> None:
    """Check that a path is a regular file, since opening a pipe could block.

    Raises:
        UsageError: the path does not exist, or is a folder, pipe or device.
    """
    if not os.path.isfile(path):
        what = "a folder, not a file" if os.path.isdir(path) else "not a regular file"
        raise UsageError(f"{path}: {what}" if os.path.exists(path) else f"no file {str(path)!r}")


def _scenes_in(folder: Path) -> list[str]:
    """Return up to `MAX_NAMED` scene files of a folder, without its subfolders."""
    scenes: list[str] = []
    with contextlib.suppress(OSError):
        for path in sorted(folder.glob("*.y*ml")):
            if len(scenes) < MAX_NAMED and path.is_file():
                with open_regular(path) as file:
                    begins = file.read(MAX_SEARCHED)
                scenes += [str(path)] if _SCENE.search(begins) and not _GRAPH.search(begins) else []
    return scenes


def _beside(name: str) -> str:
    """Return a suggestion of a YAML file with a similar name in the same folder; empty if there is none."""
    folder = os.path.dirname(name)
    try:
        there = os.listdir(folder or ".")
    except (OSError, ValueError):
        return ""
    return did_you_mean(name, [os.path.join(folder, other) for other in there if other.endswith((".yaml", ".yml"))])


def near(path: str) -> str:
    """Return a path relative to the working directory if it lies below this, otherwise unchanged."""
    relative = os.path.relpath(path)
    return path if relative.startswith("..") else relative


def installed_packages() -> list[Path]:
    """Return the folders with the ROS packages of sourced workspaces."""
    prefixes = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    return [Path(prefix).absolute() / "share" for prefix in prefixes]
