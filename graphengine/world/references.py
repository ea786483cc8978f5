"""Files that a world or a robot description names: found, judged, read, and handed to MuJoCo as bytes.

MuJoCo would open any path it is given. So includes are put in place here, every other file is read here if it lies where
files may be read, and its name in the XML is replaced by a key into `Library.assets`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from graphengine.diagnostics import Findings, did_you_mean, listing
from graphengine.files import Files
from graphengine.world.description import meshes
from graphengine.world.description.packages import REMEDY, Packages, package_of
from graphengine.world.xmlfile import MAX_DEPTH, Element, numbers, read, write

MAX_FILE_BYTES = 200_000_000
MAX_GROWTH = 50_000_000
"""Cells that one element may ask MuJoCo for: texels, samples, vertices."""
MAX_COPIES = 20_000
"""Copies that nested `replicate` elements may ask for."""

_FOLDERS = {"mesh": "meshdir", "skin": "meshdir", "flexcomp": "meshdir", "hfield": "meshdir", "texture": "texturedir"}
"""Which of the compiler's folders an element's files lie in; `assetdir` sets both."""
_NAMED_BY_FILE = ("mesh", "hfield", "texture")
_GROWING = (
    ("texture", "width", "height"),
    ("hfield", "nrow", "ncol"),
    ("composite", "count"),
    ("flexcomp", "count"),
    ("size", "nkey"),
    ("size", "nuserdata"),
)


Outcome = Literal["as it is", "converted", "unreadable", "missing"]


@dataclass(frozen=True, slots=True)
class MeshFile:
    """A mesh by its key, and the colour that its file gives it."""

    key: str
    colour: meshes.Colour | None = None


class Library:
    """The files of one scene, by the keys that MuJoCo knows them by."""

    def __init__(self, files: Files, findings: Findings) -> None:
        self.files = files
        self.findings = findings
        self.assets: dict[str, bytes] = {}
        self.models: dict[str, bytes] = {}
        self._keys: dict[Path, str] = {}
        self._meshes: dict[tuple[Path, bool], tuple[list[MeshFile] | meshes.MeshError, Outcome]] = {}
        self.outcomes: dict[str, Outcome] = {}
        """What became of the meshes of descriptions, by reference."""

    def world(self, path: Path) -> Element | None:
        """An MJCF file without a reference to any other; None when something is wrong with it."""
        before = len(self.findings.errors)
        root = self._model(path, [])
        return root if len(self.findings.errors) == before else None

    def mesh(self, element: Element, packages: Packages, *, visual: bool) -> list[MeshFile]:
        """Files that MuJoCo reads in the place of a URDF mesh: one a colour if it is looked at, else one.

        A mesh that cannot be read is an error if things collide with it; if it is only looked at, it is left out with a note.
        """
        reference, span = element.get("filename"), element.place("filename")
        self.outcomes[reference] = "missing"
        path = self._find(element, "filename", reference, packages.places(reference), "S103", packages)
        if path is None:
            return []
        kind = (path.resolve(), visual)
        if kind not in self._meshes:
            self._meshes[kind] = self._mesh_files(path, visual=visual)
        files, self.outcomes[reference] = self._meshes[kind]
        if isinstance(files, meshes.MeshError):
            what = f"the visual {reference!r} is not drawn: {files}" if visual else f"{reference!r}: {files}"
            self.findings.add("N103" if visual else "S103", what, span)
            return []
        return files

    def _mesh_files(self, path: Path, *, visual: bool) -> tuple[list[MeshFile] | meshes.MeshError, Outcome]:
        suffix, resolved = path.suffix.lower(), path.resolve()
        if suffix not in meshes.READABLE:
            legal = listing(meshes.READABLE)
            return meshes.MeshError(f"meshes of the format {suffix!r} are not read; {legal}"), "unreadable"
        if path.stat().st_size > MAX_FILE_BYTES:
            return meshes.MeshError(f"it is larger than {MAX_FILE_BYTES // 1_000_000} MB"), "unreadable"
        if resolved in self._keys:
            return [MeshFile(self._keys[resolved])], "as it is"
        data = path.read_bytes()
        if not meshes.needs_conversion(data, suffix):
            self._keys[resolved] = self._keep(path, data)
            return [MeshFile(self._keys[resolved])], "as it is"
        try:
            parts = meshes.convert(data, suffix)
        except meshes.MeshError as error:
            return error, "unreadable"
        parts = parts if visual else [meshes.merged(parts)]
        target = path.with_suffix(".msh")
        return [MeshFile(self._keep(target, meshes.msh(part)), part.colour) for part in parts], "converted"

    def _model(self, path: Path, nested: list[Path]) -> Element | None:
        root = read(path, self.findings, "S102")
        if root is None:
            return None
        if root.tag != "mujoco":
            self.findings.add("S102", f"a world begins with <mujoco>, not <{root.tag[:40]}>", root.span)
            return None
        self._include(root, path.parent, [path.resolve()], path.parent, 1)
        folders = {"meshdir": "", "texturedir": ""}
        for compiler in root.all("compiler"):
            for folder in folders:
                folders[folder] = compiler.get(folder, compiler.get("assetdir", folders[folder]))
            for name in ("meshdir", "texturedir", "assetdir", "strippath"):
                compiler.attributes.pop(name, None)
        for element in root.walk():
            self._bounded(element)
            for attribute in [name for name in element.attributes if name.startswith("file")]:
                self._asset(element, attribute, path.parent, folders, [*nested, path.resolve()])
        return root

    def _include(
        self, element: Element, folder: Path, seen: list[Path], main: Path, depth: int, copies: float = 1
    ) -> None:
        """Put what included files hold in the place of the `include`; each file once, as MuJoCo has it."""
        if element.tag == "replicate":
            copies *= (numbers(element.get("count", "1"), 1) or (1.0,))[0]
        if depth > MAX_DEPTH or copies > MAX_COPIES:
            what = (
                f"nested more than {MAX_DEPTH} levels deep" if depth > MAX_DEPTH else f"more than {MAX_COPIES} copies"
            )
            self.findings.add("S102", what, element.span)
            return
        children: list[Element] = []
        for child in element.children:
            if child.tag == "include":
                children += self._included(child, folder, seen, main, depth, copies)
            else:
                self._include(child, folder, seen, main, depth + 1, copies)
                children.append(child)
        element.children = children

    def _included(
        self, include: Element, folder: Path, seen: list[Path], main: Path, depth: int, copies: float
    ) -> list[Element]:
        reference = include.get("file")
        path = self._find(include, "file", reference, [folder / reference, main / reference], "S102")
        if path is None:
            return []
        if path.resolve() in seen:
            self.findings.add("S102", f"{reference!r} is included twice", include.place("file"))
            return []
        seen.append(path.resolve())
        root = read(path, self.findings, "S102")
        if root is None:
            return []
        self._include(root, path.parent, seen, main, depth + 1, copies)
        return root.children

    def _asset(self, element: Element, attribute: str, main: Path, folders: dict[str, str], nested: list[Path]) -> None:
        reference = element.get(attribute)
        if not reference:
            del element.attributes[attribute]
            return
        if element.tag == "model":
            self._submodel(element, attribute, reference, main, nested)
            return
        folder = main / folders.get(_FOLDERS.get(element.tag, ""), "")
        if element.tag in _NAMED_BY_FILE:
            element.attributes.setdefault("name", Path(reference).stem)
        self._take(element, attribute, reference, [folder / reference], "S102")

    def _submodel(self, element: Element, attribute: str, reference: str, main: Path, nested: list[Path]) -> None:
        path = self._find(element, attribute, reference, [main / reference], "S102")
        if path is None:
            return
        resolved = path.resolve()
        if resolved in nested:
            self.findings.add("S102", f"{reference!r} contains itself", element.place(attribute))
            return
        if resolved not in self._keys and (root := self._model(path, nested)) is not None:
            self._keys[resolved] = f"model{len(self.models)}.xml"
            self.models[self._keys[resolved]] = write(root)[0].encode()
        element.attributes[attribute] = self._keys.get(resolved, "")

    def _take(self, element: Element, attribute: str, reference: str, places: list[Path], code: str) -> None:
        """Read a file and put its key into the XML."""
        path = self._find(element, attribute, reference, places, code)
        if path is None:
            return
        resolved = path.resolve()
        if resolved not in self._keys:
            if resolved.stat().st_size > MAX_FILE_BYTES:
                limit = f"{MAX_FILE_BYTES // 1_000_000} MB"
                self.findings.add(code, f"{reference!r} is larger than {limit}", element.place(attribute))
                return
            self._keys[resolved] = self._keep(path, resolved.read_bytes())
        element.attributes[attribute] = self._keys[resolved]

    def _keep(self, path: Path, data: bytes) -> str:
        """The key of a new asset."""
        key = f"{len(self.assets)}_{path.name}"
        self.assets[key] = data
        return key

    def _find(
        self,
        element: Element,
        attribute: str,
        reference: str,
        places: list[Path],
        code: str,
        packages: Packages | None = None,
    ) -> Path | None:
        span = element.place(attribute)
        try:
            readable = [place for place in places if self.files.may_read(place)]
            found = next((place for place in readable if place.is_file()), None)
        except (OSError, RuntimeError, ValueError) as error:  # too long a name, a loop of links
            self.findings.add(code, f"cannot look up {reference[:200]!r}: {error}", span)
            return None
        if found is not None:
            return found
        if places and not readable:
            self.findings.add(
                code,
                f"{reference!r} lies outside the folder of the file you gave",
                span,
                f"allow it with --allow {places[0].resolve().parent}",
            )
            return None
        self.findings.add("S101", f"no file {reference!r}", span, *_whereabouts(reference, readable, packages))
        return None

    def _bounded(self, element: Element) -> None:
        for tag, *attributes in _GROWING:
            if element.tag != tag:
                continue
            text = " ".join(element.get(attribute, "1") for attribute in attributes)
            sizes = numbers(text, len(text.split())) or ()
            if math.prod(sizes) > MAX_GROWTH:
                span = element.place(attributes[0])
                self.findings.add("S102", f"<{tag}> asks for more than {MAX_GROWTH} cells", span)


def _whereabouts(reference: str, places: Sequence[Path], packages: Packages | None) -> list[str]:
    """What is near a file that is missing, and where it was looked for."""
    folders = list(dict.fromkeys(place.parent for place in places))
    names = [entry.name for folder in folders if folder.is_dir() for entry in folder.iterdir()]
    near = did_you_mean(Path(reference).name, names)
    looked = listing(map(str, folders), "looked in")
    package = package_of(reference)
    if packages is None or package is None or packages.find(package) is not None:
        return [near, looked]
    known = did_you_mean(package, packages.known())
    searched = listing(packages.searched(), f"no package {package!r}; looked for it")
    return [near, known, searched, looked, REMEDY]
