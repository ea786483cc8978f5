"""Reports missing files to which a world or robot description refers, with one error for each folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from graphengine.descriptions.files.packages import REMEDY, SCHEMES, Packages, package_of
from graphengine.descriptions.files.xml import Element
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import did_you_mean, listing, printable


@dataclass(frozen=True, slots=True)
class MissingFile:
    """A reference to a file that does not exist.

    Attributes:
        element: element of the description with the reference.
        attribute: name of the attribute that is the reference.
        places: paths at which the file was looked up; none for an unsupported scheme.
        packages: packages in which the reference was looked up; None for a reference that cannot name a package.
    """

    element: Element
    attribute: str
    places: Sequence[Path]
    packages: Packages | None

    @property
    def reference(self) -> str:
        """The reference as it is written in the description."""
        return self.element.get(self.attribute)


def report_missing(missing: Sequence[MissingFile], findings: Findings) -> None:
    """Add an error for each folder with missing files, at the first reference to such a file."""
    folders: dict[tuple[Path, ...], list[MissingFile]] = {}
    for each in missing:
        folders.setdefault(tuple(place.parent for place in each.places), []).append(each)
    for first, *others in folders.values():
        more = [name for name in dict.fromkeys(each.reference for each in others) if name != first.reference]
        text = f"no file {first.reference!r}"
        text += f", nor {len(more)} more in the same folder" if more else ""
        names = [listing(map(printable, more), "also missing")] if more else []
        about = _whereabouts(first.reference, first.places, first.packages)
        findings.add("S101", text, first.element.place(first.attribute), *names, *about)


def _whereabouts(reference: str, places: Sequence[Path], packages: Packages | None) -> list[str]:
    """Return remedies for a missing file: a file or package with a similar name, and the folders that were searched."""
    if not places:
        return [f"refer to a mesh by its path, or with {', '.join((*SCHEMES, 'file://'))}"]
    folders = list(dict.fromkeys(place.parent for place in places))
    names = [entry.name for folder in folders if folder.is_dir() for entry in folder.iterdir()]
    near = did_you_mean(Path(reference).name, names)
    looked = listing(map(str, folders), "looked in")
    package = package_of(reference)
    if packages is None or package is None or packages.find(package) is not None:
        return [near, looked]
    known = did_you_mean(package, packages.known())
    searched = listing(packages.searched(), f"no package {package!r}; searched for it")
    return [near, known, searched, looked, REMEDY]
