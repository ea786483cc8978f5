"""Finds the definition files of messages, services and actions in ROS packages.

Examples are `<package>/msg/Range.msg`, `<package>/srv/Trigger.srv` and `<package>/action/Dock.action`. They are in the sources of
a package and, if the package is installed, below `share/`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.format.ros_packages import manifest_name, walk
from graphengine.messages.interfaces import KINDS, TypeName

MAX_DEPTH = 6
"""Maximum depth below a given folder at which packages are searched."""

_IGNORED = frozenset(("COLCON_IGNORE", "AMENT_IGNORE"))


@dataclass(slots=True)
class Folders:
    """Folders in which definition files are looked up: first in `given`, then in `installed`.

    Args:
        given: definition files, packages, or folders with packages at any depth up to `MAX_DEPTH`.
        installed: `share` folders with installed packages, such as `/opt/ros/jazzy/share`.
    """

    given: Sequence[Path] = ()
    installed: Sequence[Path] = ()
    _index: dict[str, Path] | None = field(default=None, init=False)

    def find(self, name: TypeName) -> Path | None:
        """Return the file that defines a type, or None."""
        found = self._given().get(name.source)
        if found is not None:
            return found
        places = (share / name.package / name.kind / name.name for share in self.installed)
        files = (place.with_suffix(suffix) for place in places for suffix in (f".{name.kind}", ".idl"))
        return next((file for file in files if file.is_file()), None)

    def names(self) -> list[str]:
        """Return the names of all types that have a definition file, such as `std_srvs/srv/Trigger`."""
        files = [file for share in self.installed for kind in KINDS for file in share.glob(f"*/{kind}/*.{kind}")]
        return sorted({*self._given(), *(f"{file.parts[-3]}/{file.parts[-2]}/{file.stem}" for file in files)})

    def _given(self) -> dict[str, Path]:
        if self._index is None:
            self._index = {}
            for path in self.given:
                for file in [path] if path.is_file() else _walk(path):
                    kind = file.suffix[1:]
                    if kind in KINDS:
                        package = _package_of(file.absolute().parent, kind)
                        self._index.setdefault(f"{package}/{kind}/{file.stem}", file)
        return self._index


def _walk(folder: Path) -> Iterator[Path]:
    for place, names in walk(folder, MAX_DEPTH, _is_ignored):
        if place == folder or not _is_ignored(names):
            yield from (place / name for name in sorted(names))


def _is_ignored(names: Sequence[str]) -> bool:
    return not _IGNORED.isdisjoint(names)


def _package_of(folder: Path, kind: str) -> str:
    """Return the name of the package to which a folder with definition files belongs.

    This is the name in the package manifest; without a manifest, the name of the package's folder.
    """
    root = folder.parent if folder.name == kind else folder
    return manifest_name(root) or root.name
