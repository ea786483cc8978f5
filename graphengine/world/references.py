"""Files that a world or a robot description names: found, judged, read, and handed to MuJoCo as bytes.

MuJoCo would open any path it is given. So includes are put in place here, every other file is read here if it lies where
files may be read, and its name in the XML is replaced by a key into `Library.assets`.
"""

from __future__ import annotations

import math
from pathlib import Path

from graphengine.diagnostics import Findings, did_you_mean
from graphengine.files import Files
from graphengine.world.xmlfile import MAX_DEPTH, Element, numbers, read, write

MAX_FILE_BYTES = 200_000_000
MAX_GROWTH = 50_000_000
"""Cells that one element may ask MuJoCo for: texels, samples, vertices."""
MAX_COPIES = 20_000
"""Copies that nested `replicate` elements may ask for."""

_FOLDERS = {"mesh": "meshdir", "skin": "meshdir", "flexcomp": "meshdir", "hfield": "meshdir", "texture": "texturedir"}
"""Which of the compiler's folders an element's files lie in; `assetdir` sets both."""
_NAMED_BY_FILE = ("mesh", "hfield", "texture")
READABLE_MESHES = (".stl", ".obj", ".msh")
_GROWING = (
    ("texture", "width", "height"),
    ("hfield", "nrow", "ncol"),
    ("composite", "count"),
    ("flexcomp", "count"),
    ("size", "nkey"),
    ("size", "nuserdata"),
)


class Library:
    """The files of one scene, by the keys that MuJoCo knows them by."""

    def __init__(self, files: Files, findings: Findings) -> None:
        self.files = files
        self.findings = findings
        self.assets: dict[str, bytes] = {}
        self.models: dict[str, bytes] = {}
        self._keys: dict[Path, str] = {}

    def world(self, path: Path) -> Element | None:
        """An MJCF file without a reference to any other; None when something is wrong with it."""
        before = len(self.findings.errors)
        root = self._model(path, [])
        return root if len(self.findings.errors) == before else None

    def mesh(self, element: Element, folder: Path) -> None:
        """Take the file of a URDF mesh; `package://name/x` is looked for around the description's folder."""
        reference = element.get("filename")
        plain = reference.removeprefix("file://")
        places = [folder / plain]
        if plain.startswith("package://"):
            package, _, rest = plain.removeprefix("package://").partition("/")
            around = (folder, *folder.resolve().parents)
            places = [place for parent in around for place in (parent / package / rest, parent / rest)]
        key = self._take(element, "filename", reference, places, "S103")
        if key and Path(key).suffix.lower() not in READABLE_MESHES:
            self.findings.add(
                "S103",
                f"MuJoCo cannot read {Path(reference).suffix!r} meshes",
                element.place("filename"),
                f"convert it to one of {', '.join(READABLE_MESHES)}, or collide with a box, cylinder or sphere",
            )

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

    def _take(self, element: Element, attribute: str, reference: str, places: list[Path], code: str) -> str | None:
        """Read a file and put its key into the XML."""
        path = self._find(element, attribute, reference, places, code)
        if path is None:
            return None
        resolved = path.resolve()
        if resolved not in self._keys:
            if resolved.stat().st_size > MAX_FILE_BYTES:
                limit = f"{MAX_FILE_BYTES // 1_000_000} MB"
                self.findings.add(code, f"{reference!r} is larger than {limit}", element.place(attribute))
                return None
            self._keys[resolved] = f"{len(self.assets)}_{path.name}"
            self.assets[self._keys[resolved]] = resolved.read_bytes()
        element.attributes[attribute] = self._keys[resolved]
        return self._keys[resolved]

    def _find(self, element: Element, attribute: str, reference: str, places: list[Path], code: str) -> Path | None:
        span = element.place(attribute)
        try:
            readable = [place for place in places if self.files.may_read(place)]
            found = next((place for place in readable if place.is_file()), None)
        except (OSError, RuntimeError, ValueError) as error:  # too long a name, a loop of links
            self.findings.add(code, f"cannot look up {reference[:200]!r}: {error}", span)
            return None
        if found is not None:
            return found
        if not readable:
            self.findings.add(
                code,
                f"{reference!r} lies outside the folder of the file you gave",
                span,
                f"allow it with --allow {places[0].resolve().parent}",
            )
            return None
        folder = readable[0].parent
        names = [entry.name for entry in folder.iterdir()] if folder.is_dir() else []
        near = did_you_mean(Path(reference).name, names)
        self.findings.add("S101", f"no file {reference!r}", span, near, f"looked in {folder}")
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
