"""Finds the files to which a description refers: by relative path, in a ROS package, or by absolute path.

A package is a folder that has the package's name, or whose `package.xml` contains the name. Packages are looked up in this
order: in the folders around the description (usually the package itself), in the `package_paths` of the robot file, and in the
folders that the user allows.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from graphengine.format.files import INCLUDED, Files
from graphengine.format.ros_packages import MANIFEST, manifest_name, package_folder, walk
from graphengine.format.wording import did_you_mean, listing

SCHEMES = ("package://", "model://")
"""Schemes of references to files in packages, as in `package://NAME/FILE`."""
MODELS = "models"
"""Folder in which a package may contain Gazebo models; a model is found like a package, but has no `package.xml`."""
MAX_DEPTH = 4
"""Number of levels below a search path at which packages are looked for, as in `src/repository/package`."""
REMEDY = "name its folder by package_paths in the robot file, or by --package-path on import"
"""Remedy in messages about a package that is not found."""


class Packages:
    """The packages to which a description can refer.

    Args:
        folder: folder of the description; relative references start from it.
        paths: folders of packages, or folders with packages up to `MAX_DEPTH` levels below. After these, the roots of `files`
            are searched, except those with included graphs and scenes, whose folders have common names such as `arm`.
        files: decides which files may be read.
    """

    def __init__(self, folder: Path, paths: Sequence[Path], files: Files) -> None:
        self.folder = folder
        included = [files.base / name for name in INCLUDED]
        roots = [root for root in files.roots if not any(root.is_relative_to(folder) for folder in included)]
        self.paths = tuple(dict.fromkeys((*paths, *roots)))
        self.files = files
        self._found: dict[str, Path | None] = {}

    def find(self, name: str) -> Path | None:
        """Return the folder of a package: the first found that may be read, else the first found, else None."""
        if name not in self._found:
            found = (folder for folder in self._candidates(name) if self._is(folder, name))
            first = next(found, None)
            readable = (folder for folder in (first, *found) if folder is not None and self.files.may_read(folder))
            self._found[name] = next(readable, first)
        return self._found[name]

    def places(self, reference: str) -> list[Path]:
        """Return the paths at which the file of a reference may be, most likely first; none for an unsupported scheme.

        If the package of a reference is not found, each folder that contains the description, but no manifest, is tried as the
        package, because a package without a manifest may be in a folder with another name.
        """
        if reference.startswith("file://"):
            return [self.folder / unquote(reference.removeprefix("file://"))]
        name = package_of(reference)
        if name is None:
            return [self.folder / reference] if "://" not in reference else []
        package, rest = self.find(name), reference.partition("://")[2].lstrip("/").partition("/")[2]
        if package is not None:
            return [package / rest]
        around = [self.folder, *self.folder.resolve().parents]
        return [folder / rest for folder in around if self._name_of(folder) is None]

    def reference(self, text: str, folder: Path) -> str:
        """Return a reference for the absolute path of a file: `package://`, or a path relative to `folder` outside of packages.

        Other texts, and paths of files that may not be read, are returned unchanged.
        """
        path = Path(text)
        if not text.startswith("/") or not self.files.may_read(path) or not path.is_file():
            return text
        package = package_folder(path)
        name = self._name_of(package)
        return f"{SCHEMES[0]}{name}/{path.resolve().relative_to(package)}" if name else os.path.relpath(path, folder)

    def searched(self) -> list[str]:
        """Return the folders in which packages are looked up, as text for a message."""
        told = {self.folder.resolve(): f"around {self.folder}"}
        for path in self.paths:
            told.setdefault(path.resolve(), str(path))
        return list(told.values())

    def lacks(self, name: str) -> list[str]:
        """Return the lines of the message for a missing package: the error, then remedies."""
        searched = listing(self.searched(), "looked in")
        return [f"no package {name!r}", *filter(None, (did_you_mean(name, self.known()), searched, REMEDY))]

    def known(self) -> list[str]:
        """Return the names of all packages with a manifest in the search paths."""
        return sorted({name for path in self.paths for folder in _below(path) if (name := self._name_of(folder))})

    def _candidates(self, name: str) -> Iterator[Path]:
        for path in (self.folder, *self.folder.resolve().parents, *self.paths):
            yield path
            yield path / name
            yield path / MODELS / name
        for path in self.paths:  # after the usual layout, because the search of a large tree takes a while
            yield from _below(path)

    def _is(self, folder: Path, name: str) -> bool:
        try:
            return folder.is_dir() and name in (folder.resolve().name, self._name_of(folder))
        except (OSError, RuntimeError, ValueError):  # an impossible folder name, or a loop of symbolic links
            return False

    def _name_of(self, folder: Path) -> str | None:
        """Return the package name in the manifest of a folder; None without a readable manifest."""
        manifest = folder / MANIFEST
        if not self.files.may_read(manifest) or not manifest.is_file():
            return None
        self.files.note(manifest)
        return manifest_name(folder)


def package_of(reference: str) -> str | None:
    """Return the name of the package in a `package://` or `model://` reference; None for other references."""
    scheme, separator, rest = reference.partition("://")
    return rest.lstrip("/").partition("/")[0] or None if f"{scheme}{separator}" in SCHEMES else None


def _below(path: Path) -> Iterator[Path]:
    """Return an iterator over a folder and the folders below it, parents first; folders inside packages are skipped."""
    return (folder for folder, _ in walk(path, MAX_DEPTH, lambda names: MANIFEST in names))
