"""Finds, checks and reads the files that a world or robot description names, and passes them to MuJoCo as bytes.

MuJoCo would open any path. So this module inserts includes, reads all other files that may be read, and replaces their names in
the XML by keys of `Library.assets`.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.ros_packages import package_folder
from graphengine.format.wording import did_you_mean, listing
from graphengine.physics.files import meshes
from graphengine.physics.files.bounds import HOW_CELLS_COUNT, MAX_CELLS, cells_of_file, weigh
from graphengine.physics.files.conversion import Foreign, convert_all
from graphengine.physics.files.packages import REMEDY, SCHEMES, Packages, package_of
from graphengine.physics.files.xml import MAX_DEPTH, Element, parse, read, write
from graphengine.sandbox.borders import warn

MAX_FILE_BYTES = 200_000_000

_FOLDERS = {"mesh": "meshdir", "skin": "meshdir", "flexcomp": "meshdir", "hfield": "meshdir", "texture": "texturedir"}
"""Which of the compiler's folders an element's files lie in; `assetdir` sets both."""
_CODE = ("plugin", "extension")
"""Elements that make MuJoCo run code of a plugin."""
_NAMED_BY_FILE = ("mesh", "hfield", "texture")

Outcome = Literal["unchanged", "converted", "unreadable", "missing"]


@dataclass(frozen=True, slots=True)
class MeshFile:
    """The key of a mesh in `Library.assets`, and the colour in the mesh file; None without a colour."""

    key: str
    colour: meshes.Colour | None = None


@dataclass(frozen=True, slots=True)
class _Mesh:
    """A loaded mesh file: the files that MuJoCo reads, or the reason why there are none."""

    outcome: Outcome
    files: list[MeshFile]
    why: str = ""


class _FileKind(NamedTuple):
    """The resolved path of a mesh file, the suffix of its name in the description, and whether the mesh is a visual."""

    path: Path
    suffix: str
    visual: bool


class _UnreadableError(Exception):
    """A file that may not or cannot be read; the message gives the reason."""


class Library:
    """The files of a scene, by the keys under which MuJoCo finds them."""

    def __init__(self, files: Files, findings: Findings) -> None:
        self.files = files
        self.findings = findings
        self.assets: dict[str, bytes] = {}
        self.models: dict[str, bytes] = {}
        self._keys: dict[Path, str] = {}
        self._included_files: dict[Path, str] = {}
        """The keys are the files inserted by `include`, with symbolic links resolved."""
        self._meshes: dict[_FileKind, _Mesh] = {}
        self._heaviest = 0.0
        """Number of cells of the largest model so far, as counted by `bounds`."""
        self._unfolded = 0
        """Number of cells of all files read so far."""
        self.outcomes: dict[str, Outcome] = {}
        """Outcome of loading each mesh of the descriptions, by reference."""

    def copy(self, files: Files) -> Library:
        """Return a copy that reads further files independently of this one."""
        made = copy.copy(self)
        made.files = files
        for name, value in vars(self).items():
            if isinstance(value, dict):
                setattr(made, name, dict(value))
        return made

    def world(self, path: Path, text: str | None = None) -> Element | None:
        """Return an MJCF file or text without references to other files; None if there are errors."""
        before = len(self.findings.errors)
        root = self._model(path, [], text)
        return root if len(self.findings.errors) == before else None

    def read_files(self) -> list[Path]:
        """Return the files that models include or refer to, with symbolic links resolved."""
        return list(dict.fromkeys([*self._included_files, *self._keys]))

    def source(self, key: str) -> Path | None:
        """Return the path of the file that was loaded under a key of `assets`; None if there is none."""
        return next((path for path, known in self._keys.items() if known == key), None)

    def meshes(self, shapes: Sequence[tuple[Element, bool]], packages: Packages) -> dict[Element, list[MeshFile]]:
        """Return files that MuJoCo can read for URDF meshes: one per colour for a visible mesh, else one.

        A mesh that cannot be read is an error if it is a collider; otherwise it is left out with a note.

        Args:
            shapes: meshes, and whether each is a visual.
            packages: packages of the description.
        """
        kinds: dict[Element, _FileKind] = {}
        for element, visual in shapes:
            reference = element.get("filename")
            self.outcomes[reference] = "missing"
            path = self._find(element, "filename", packages.places(reference), "S103", packages)
            if path is not None:
                kinds[element] = _FileKind(path.resolve(), path.suffix.lower(), visual)
        self._load(dict.fromkeys(kind for kind in kinds.values() if kind not in self._meshes))
        return {element: self._files(element, kind) for element, kind in kinds.items()}

    def _files(self, element: Element, kind: _FileKind) -> list[MeshFile]:
        """Return the files of a loaded mesh; report errors."""
        reference, mesh = element.get("filename"), self._meshes[kind]
        self.outcomes[reference] = mesh.outcome
        if mesh.outcome == "unreadable":
            code, what = ("N103", "the visual {!r} is not drawn: {}") if kind.visual else ("S103", "{!r}: {}")
            self.findings.add(code, what.format(reference, mesh.why), element.place("filename"))
        return mesh.files

    def _load(self, kinds: Iterable[_FileKind]) -> None:
        """Read meshes, and convert those that MuJoCo cannot read, all at once."""
        foreign: dict[_FileKind, Foreign] = {}
        for kind in sorted(kinds):  # a file that is looked at and collided with follows itself
            try:
                data = self._mesh_data(kind)
            except _UnreadableError as error:
                self._meshes[kind] = _Mesh("unreadable", [], str(error))
                continue
            if meshes.needs_conversion(data, kind.suffix):
                foreign[kind] = Foreign(data, kind.suffix, kind.visual)
                continue
            if kind.path not in self._keys:
                self._keys[kind.path] = self._keep(f"{kind.path.stem}{kind.suffix}", data)
            self._meshes[kind] = _Mesh("unchanged", [MeshFile(self._keys[kind.path])])
        if foreign:
            warn(self.findings)
        for kind, became in zip(foreign, convert_all(list(foreign.values())), strict=True):
            if isinstance(became, meshes.MeshError):
                self._meshes[kind] = _Mesh("unreadable", [], str(became))
            else:
                files = [MeshFile(self._keep(f"{kind.path.stem}.msh", part.data), part.colour) for part in became]
                self._meshes[kind] = _Mesh("converted", files)

    def _mesh_data(self, kind: _FileKind) -> bytes:
        if kind.path in self._keys:
            return self.assets[self._keys[kind.path]]
        if kind.suffix not in meshes.READABLE:
            raise _UnreadableError(
                f"meshes of the format {kind.suffix!r} are not supported; {listing(meshes.READABLE)}"
            )
        return _content(kind.path)

    def _model(self, path: Path, nested: list[Path], text: str | None = None) -> Element | None:
        code = "S102"
        root = read(path, self.findings, code) if text is None else parse(text.encode(), path.name, self.findings, code)
        if root is None:
            return None
        if root.tag != "mujoco":
            self.findings.add("S102", f"a MuJoCo model begins with <mujoco>, not <{root.tag[:40]}>", root.span)
            return None
        self._include(root, path.parent, [path.resolve()], path.parent, 1)
        for element in root.walk():
            if element.tag in _CODE:
                text = f"<{element.tag}>: plugins of MuJoCo are code, which files here cannot use"
                self.findings.add("S102", text, element.span, "leave it out")
                return None
        folders = {"meshdir": "", "texturedir": ""}
        for compiler in root.all("compiler"):
            for folder in folders:
                folders[folder] = compiler.get(folder, compiler.get("assetdir", folders[folder]))
            for name in ("meshdir", "texturedir", "assetdir", "strippath"):
                compiler.attributes.pop(name, None)
        for element in root.walk():
            for attribute in [name for name in element.attributes if name.startswith("file")]:
                self._asset(element, attribute, path.parent, folders, [*nested, path.resolve()])
        cells, culprit = weigh(root, self._heaviest)
        if culprit is not None:
            what = f"with this <{culprit.tag}> the world unfolds to more than {MAX_CELLS // 10**6} million cells"
            self.findings.add("S102", what, culprit.span, HOW_CELLS_COUNT)
        self._heaviest = max(self._heaviest, cells)
        return root

    def _include(self, element: Element, folder: Path, seen: list[Path], main: Path, depth: int) -> None:
        """Replace each `include` by the content of its file; each file is included once, as in MuJoCo."""
        if depth > MAX_DEPTH:
            self.findings.add("S102", f"nested more than {MAX_DEPTH} levels deep", element.span)
            return
        children: list[Element] = []
        for child in element.children:
            if child.tag == "include":
                children += self._included(child, folder, seen, main, depth)
            else:
                self._include(child, folder, seen, main, depth + 1)
                children.append(child)
        element.children = children

    def _included(self, include: Element, folder: Path, seen: list[Path], main: Path, depth: int) -> list[Element]:
        reference = include.get("file")
        path = self._find(include, "file", [folder / reference, main / reference], "S102")
        if path is None:
            return []
        if path.resolve() in seen:
            self.findings.add("S102", f"{reference!r} is included twice", include.place("file"))
            return []
        seen.append(path.resolve())
        self._included_files[path.resolve()] = ""
        root = read(path, self.findings, "S102")
        if root is None:
            return []
        self._include(root, path.parent, seen, main, depth + 1)
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
        self._take(element, attribute, folder / reference)

    def _submodel(self, element: Element, attribute: str, reference: str, main: Path, nested: list[Path]) -> None:
        path = self._find(element, attribute, [main / reference], "S102")
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

    def _take(self, element: Element, attribute: str, place: Path) -> None:
        """Read a file and write its key into the XML."""
        reference = element.get(attribute)
        path = self._find(element, attribute, [place], "S102")
        if path is None:
            return
        resolved = path.resolve()
        if resolved not in self._keys:
            try:
                data = _content(resolved)
            except _UnreadableError as error:
                self.findings.add("S102", f"{reference!r}: {error}", element.place(attribute))
                return
            self._unfolded += cells_of_file(element.tag, data)
            if self._unfolded > MAX_CELLS:
                what = f"with {reference!r} the world's files unfold to more than {MAX_CELLS // 10**6} million cells"
                self.findings.add("S102", what, element.place(attribute), HOW_CELLS_COUNT)
                return
            self._keys[resolved] = self._keep(path.name, data)
        element.attributes[attribute] = self._keys[resolved]

    def _keep(self, name: str, data: bytes) -> str:
        """Return the key of a new asset; MuJoCo reads the suffix of its name."""
        key = f"{len(self.assets)}_{name}"
        self.assets[key] = data
        return key

    def _find(
        self, element: Element, attribute: str, places: list[Path], code: str, packages: Packages | None = None
    ) -> Path | None:
        reference, span = element.get(attribute), element.place(attribute)
        try:
            readable = [place for place in places if self.files.may_read(place)]
            found = next((place for place in readable if self._is_there(place)), None)
            outside = package_folder(places[0]) if places and not readable else None
        except (OSError, RuntimeError, ValueError) as error:  # too long a name, a loop of links
            self.findings.add(code, f"cannot look up {reference[:200]!r}: {error}", span)
            return None
        if found is not None:
            self.files.note(found)
            return found
        if outside is not None:
            what = f"{reference!r} lies outside the folder of the file you gave"
            self.findings.add(code, what, span, f"allow it with --allow {outside}")
            return None
        self.findings.add("S101", f"no file {reference!r}", span, *_whereabouts(reference, readable, packages))
        return None

    def _is_there(self, place: Path) -> bool:
        if place.is_file():
            return True
        self.files.note_missing(place)
        return False


def _content(path: Path) -> bytes:
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise _UnreadableError(f"the file is larger than {MAX_FILE_BYTES // 1_000_000} MB")
        return path.read_bytes()
    except OSError as error:
        raise _UnreadableError(f"the file cannot be read: {error.strerror or error}") from None


def _whereabouts(reference: str, places: Sequence[Path], packages: Packages | None) -> list[str]:
    """Return lines of help for a missing file: a file with a similar name, and the folders that were searched."""
    if not places:
        return [f"meshes are named by their path, or with {', '.join((*SCHEMES, 'file://'))}"]
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
