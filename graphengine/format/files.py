"""Finds the files that arguments and other files refer to, and checks that they lie in folders that may be read.

A reference is looked up beside the file that contains the reference, then among the graphs and scenes of this package. The found
file must lie in the folder of the file that the user gave, in this package, in an installed ROS package, or in a folder that the
user allowed. An untrusted scene therefore cannot read other files.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from graphengine.format.diagnostics import Findings, Span
from graphengine.format.errors import UsageError
from graphengine.format.given_text import GivenText
from graphengine.format.regular_files import StrPath, open_regular
from graphengine.format.wording import allowing, did_you_mean, listing, quoted


def shipped() -> Path:
    """Return the folder with the included `graphs/` and `scenes/`: `_data` in a wheel, otherwise the checkout."""
    package = Path(__file__).resolve().parents[1]
    data = package / "_data"
    return data if data.is_dir() else package.parent


Signature = tuple[int, ...] | None
"""Mode, inode, size and times of a file, for the detection of changes; None for a missing file."""


def signature(path: StrPath) -> Signature:
    """Return mode, inode, size and times of the file or folder at a path, without opening it; None if the path does not exist."""
    try:
        found = os.stat(path)
    except (OSError, ValueError):
        return None
    return found.st_mode, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


PACKAGE = "package://"
"""Prefix of a reference to a file in a ROS package, as in `package://my_robot/scenes/hall.yaml`."""
YAML = (".yaml", ".yml")
INCLUDED = ("scenes", "graphs")
"""Folders with included files, in the order in which a name is looked up."""
USD = (".usd", ".usda", ".usdc", ".usdz")
STAGE = "USD stage, of which robots, worlds and ActionGraphs can be read"
"""Name of USD files in messages."""
OTHERS = (
    ((".urdf", ".xacro", ".sdf", ".mjcf", ".xml", ".world"), "a description", "import-robot", " -o robots/NAME.yaml"),
    ((".py",), "a script of Isaac Sim", "import", ""),
    (USD, f"a {STAGE}", "import", ""),
    ((".mcap",), "a recording", "replay", ""),
)
"""For each kind of file other than scenes and graphs: suffixes, name for messages, the verb that reads it, more arguments."""
MAX_NAMED = 5
"""Maximum number of scene files in the error message for a folder."""
MAX_SEARCHED = 10_000
"""Number of bytes at the beginning of a file in which the keys `scene` and `graph` are searched."""
_SCENE, _GRAPH = re.compile(rb"^scene\s*:", re.MULTILINE), re.compile(rb"^graph\s*:", re.MULTILINE)


class NotFoundError(Exception):
    """A file does not exist or may not be read.

    Args:
        message: text that says what is wrong.
        help: lines with remedies; empty lines are allowed.
    """

    def __init__(self, message: str, *help: str) -> None:
        super().__init__(message)
        self.message = message
        self.help = help


@dataclass(frozen=True, slots=True)
class Files:
    """The folders from which files may be read, and a record of the files that were read or not found."""

    roots: tuple[Path, ...]
    near: Path | None = None
    """Working directory; messages show relative paths for files in this folder. None: messages show paths unchanged."""
    installed: tuple[Path, ...] = ()
    """Folders with installed ROS packages, such as `install/share`; `roots` has these folders too."""
    base: Path = field(default_factory=shipped)
    """Folder with the included `graphs/` and `scenes/`."""
    texts: Mapping[Path, GivenText] = field(default_factory=dict, compare=False, repr=False)
    """Each text that a program passed instead of a file, by the absolute path that stands for the text."""
    used: dict[Path, Signature] = field(default_factory=dict, compare=False, repr=False)
    """Signature of each file from before it was read, by absolute path, in the order of reading."""
    sought: dict[Path, Signature] = field(default_factory=dict, compare=False, repr=False)
    """Signature of each path where a file was looked up and not found; None unless the path is a folder, pipe or device."""

    @staticmethod
    def of(
        given: Path,
        allowed: Sequence[Path] = (),
        near: Path | None = None,
        installed: Sequence[Path] = (),
        base: Path | None = None,
        text: GivenText | None = None,
    ) -> Files:
        """Return a record for a scene or graph file that the user gives, with access to files in the file's folder and below.

        Args:
            given: path of the file.
            allowed: additional folders that the user allows to be read.
            near: working directory, as in the attribute `near`.
            installed: folders that contain installed ROS packages.
            base: folder with the included `graphs/` and `scenes/`; None: the result of `shipped`.
            text: text instead of the file; `given` is then the text's label in the folder where relative paths start.
        """
        base = base or shipped()
        roots = (base / "graphs", base / "scenes", *(path.resolve() for path in (*allowed, *installed)))
        near = near.resolve() if near else None
        texts = {Path(os.path.abspath(given)): text} if text is not None else {}
        return Files(roots, near, tuple(path.absolute() for path in installed), base, texts).beside(given)

    def beside(self, given: Path) -> Files:
        """Record `given`; return a copy that also allows reading in the folder of `given`, and that shares this record."""
        self.note(given)
        return replace(self, roots=(given.resolve().parent, *self.roots))

    def note(self, path: Path) -> None:
        """Record the signature of a file before the file is read; the signature of an already recorded file stays."""
        place = Path(os.path.abspath(path))
        if place not in self.used:
            self.used[place] = signature(place)

    def note_missing(self, path: Path) -> None:
        """Record that no file was found at a path, so that a new file at the path counts as a change."""
        place = Path(os.path.abspath(path))
        self.sought[place] = signature(place)

    def text(self, path: Path) -> GivenText | None:
        """Return the text that replaces the file at a path; None for a file."""
        return self.texts.get(Path(os.path.abspath(path)))

    def content(self, path: Path) -> bytes:
        """Return the content of a file, or of the text that replaces the file.

        Raises:
            OSError: the file cannot be read.
        """
        if (text := self.text(path)) is not None:
            return text.data
        with open_regular(path) as file:
            return file.read()

    def include(self, other: Files) -> None:
        """Add the paths and signatures of another record; already recorded paths keep their signatures."""
        self.used.update(other.used | self.used)
        self.sought.update(other.sought | self.sought)

    def noted(self) -> dict[Path, Signature]:
        """Return all recorded paths with their recorded signatures."""
        return self.sought | self.used

    def changed(self) -> set[Path]:
        """Return the recorded paths whose files have since changed, appeared or disappeared."""
        return {path for path, before in self.noted().items() if signature(path) != before}

    def links(self) -> Iterator[Path]:
        """Yield the symbolic links in installed ROS packages; each target may be read, even outside of the allowed folders."""
        for top in self.installed:
            for folder, folders, names in os.walk(top):
                yield from (path for name in (*folders, *names) if (path := Path(folder, name)).is_symlink())

    def find(self, reference: str, folder: Path) -> Path:
        """Find the file that another file in `folder` refers to as `reference`; return the path for messages (see `shown`).

        Raises:
            NotFoundError: the file does not exist, or lies outside the folders that may be read.
        """
        base = self.base
        names = [reference] if os.path.splitext(reference)[1] else [reference, f"{reference}.yaml"]
        included = [base / kind / name for name in names for kind in INCLUDED]
        places = [folder / reference, base / reference, *included]
        for place in places:
            if os.path.isfile(place):  # False for illegal names, too
                if not self.may_read(place):
                    outside = f"{reference!r} lies outside the folder of the file you gave"
                    raise NotFoundError(outside, allowing(place.resolve().parent))
                self.note(place)
                return self.shown(place)
            if self.may_read(place):
                self.note_missing(place)
        looked = f"looked in {str(places[0].parent)!r}, and among the included graphs and scenes"
        raise NotFoundError(f"no file {reference!r}", self._near(reference, places), looked)

    def look_up(
        self,
        reference: str,
        folder: Path,
        findings: Findings,
        span: Span | None,
        owner: str = "",
        *,
        stages: bool = False,
    ) -> Path | None:
        """Return the path of the file that a reference means, as `find` does; add errors to `findings`, and then return None.

        Args:
            reference: path as it is written in a file.
            folder: folder of the file that contains the reference.
            findings: receives the error.
            span: position of the reference.
            owner: beginning of the error message that says which entry needs the file, such as `graph 'clock': `.
            stages: whether the reference may name a USD stage.
        """
        try:
            path = self.find(reference, folder)
        except NotFoundError as error:
            findings.add("S101", f"{owner}{error.message}", span, *error.help)
            return None
        if stages or path.suffix.lower() not in USD:
            return path
        advice = (
            "a robot of a stage belongs into `robots:`, as NAME: {use: FILE}, and the world of a stage into `world:`"
        )
        command = f"read its ActionGraphs: graphrun import {quoted(self.shown(path))}"
        findings.add("S101", f"{owner}{str(reference)!r} is a {STAGE}", span, advice, command)
        return None

    def shown(self, path: Path) -> Path:
        """Return the path for messages: relative for a file in the working directory, otherwise unchanged."""
        if self.near is not None and path.resolve().is_relative_to(self.near):
            return path.resolve().relative_to(self.near)
        return path

    def may_read(self, path: Path) -> bool:
        """Return whether a file, with symbolic links resolved, lies below one of `roots`.

        Links in installed ROS packages may lead anywhere, because `colcon build --symlink-install` makes links to the sources.
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


def _in_package(reference: str) -> Path:
    """Return the path of the file that `package://PACKAGE/PATH` means.

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
        beside = str(folders[0] / path)
        raise NotFoundError(f"no file {path!r} in the package {package!r}", did_you_mean(beside, _yaml_files(beside)))
    known = {name for share in shares if os.path.isdir(share) for name in os.listdir(share)}
    remedy = did_you_mean(package, known) if known else "no ROS workspace is sourced: source install/setup.bash"
    raise NotFoundError(f"no package {package!r}", remedy)


def find_file(name: str) -> Path:
    """Return the path of the scene or graph file that a command-line argument means; relative in the working directory.

    The argument is a path, the name of an included file, or a file of a ROS package in a sourced workspace, such as
    `package://my_robot/scenes/hall.yaml` or `my_robot/scenes/hall.yaml`.

    Raises:
        UsageError: no such file exists.
    """
    base = shipped()
    shares = [share / name for share in installed_packages()]
    included = [base / folder / f"{name}{ending}" for folder in INCLUDED for ending in ("", ".yaml")]
    try:
        places = [_in_package(name)] if name.startswith(PACKAGE) else [Path(name), *included, base / name, *shares]
    except NotFoundError as error:
        raise UsageError("\n  ".join(filter(None, (error.message, *error.help)))) from None
    for place in places:
        if os.path.isfile(place):
            require_suffix(place, "run")
            return Path(near(str(place)))
    if os.path.isdir(name) and (scenes := _scenes_in(Path(name))):
        raise UsageError(f"{name}: a folder, not a file\n  try {' or '.join(scenes)}")
    if os.path.exists(name):
        require_file(name)
    known = {folder: _names_in(base / folder) for folder in INCLUDED}
    beside = _yaml_files(name)
    guess = did_you_mean(name, [*beside, *itertools.chain(*known.values())])
    if name.endswith(YAML):  # a file of the user, so no name of an included one
        hints = [listing(sorted(beside), f"YAML files in {os.path.dirname(name) or 'this folder'}")]
    else:
        hints = [f"{folder} that ship: {', '.join(names)}" for folder, names in known.items() if names]
    raise UsageError("\n  ".join([f"no file {name!r}", *([guess] if guess else hints)]))


def require_suffix(path: str | Path, verb: str) -> None:
    """Check that the suffix of a file does not belong to another verb, as `.urdf` belongs to `import-robot`.

    Raises:
        UsageError: the suffix belongs to another verb; the message has the command for the file.
    """
    for suffixes, what, other, more in OTHERS:
        if Path(path).suffix.lower() in suffixes and other != verb:
            raise UsageError(f"{path}: {what}\n  graphrun {other} {quoted(path)}{more}")


def _names_in(folder: Path) -> list[str]:
    """Return the sorted names of the included YAML files below a folder: relative paths without `.yaml`.

    Files in `robots` and `sensors` are left out, because they cannot be run alone.
    """
    names = sorted(str(path.relative_to(folder).with_suffix("")) for path in folder.rglob("*.yaml"))
    return [name for name in names if name.partition("/")[0] not in ("robots", "sensors")]


def require_file(path: str | Path) -> None:
    """Check that a path is a regular file, because opening a pipe could block.

    Raises:
        UsageError: the path does not exist, or is a folder, pipe or device.
    """
    if not os.path.isfile(path):
        what = "a folder, not a file" if os.path.isdir(path) else "not a regular file"
        raise UsageError(f"{path}: {what}" if os.path.exists(path) else f"no file {str(path)!r}")


def _scenes_in(folder: Path) -> list[str]:
    """Return the paths of up to `MAX_NAMED` scene files in a folder, without its subfolders."""
    scenes: list[str] = []
    with contextlib.suppress(OSError):
        for path in sorted(folder.glob("*.y*ml")):
            if len(scenes) < MAX_NAMED and path.is_file():
                with open_regular(path) as file:
                    begins = file.read(MAX_SEARCHED)
                scenes += [str(path)] if _SCENE.search(begins) and not _GRAPH.search(begins) else []
    return scenes


def _yaml_files(name: str) -> list[str]:
    """Return the paths of the YAML files in the folder of the file `name`; empty if the folder cannot be read."""
    folder = os.path.dirname(name)
    try:
        return [os.path.join(folder, other) for other in os.listdir(folder or ".") if other.endswith(YAML)]
    except (OSError, ValueError):
        return []


def near(path: str) -> str:
    """Return a path in the working directory as a relative path, and any other path unchanged."""
    relative = os.path.relpath(path)
    return path if relative.startswith("..") else relative


def installed_packages() -> list[Path]:
    """Return the `share` folders of the sourced ROS workspaces, which the environment variable AMENT_PREFIX_PATH lists."""
    prefixes = filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep))
    return [Path(prefix).absolute() / "share" for prefix in prefixes]
