"""Finds, checks and reads the files to which a world or robot description refers, and passes them to MuJoCo as bytes.

MuJoCo would open any path. Therefore this module inserts included files, reads all other files if they may be read, and replaces
their names in the XML by keys of `Library.assets`.
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Sequence
from pathlib import Path

from graphengine.descriptions.files import meshes
from graphengine.descriptions.files.bounds import HOW_MEMORY_COUNTS, MAX_MEMORY, TOO_LARGE, weigh
from graphengine.descriptions.files.conversion import Foreign, convert_all
from graphengine.descriptions.files.flat_meshes import THICKNESS, is_flat, thickened
from graphengine.descriptions.files.mesh_file import LoadedMesh, MeshFile, MeshKind, Outcome
from graphengine.descriptions.files.missing_files import MissingFile, report_missing
from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import MAX_DEPTH, Element, numbers, parse, read, write
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files, shipped
from graphengine.format.regular_files import open_regular
from graphengine.format.ros_packages import package_folder
from graphengine.format.wording import allowing, listing
from graphengine.sandbox.borders import warn

MAX_FILE_BYTES = 200_000_000
"""Maximum size of one mesh or texture file, bytes."""
MAX_FILES_BYTES = 500_000_000
"""Maximum size of all files together to which a scene refers, bytes."""

_FOLDERS = {"mesh": "meshdir", "skin": "meshdir", "flexcomp": "meshdir", "hfield": "meshdir", "texture": "texturedir"}
"""For each tag: the attribute of <compiler> that names the folder of an element's files; `assetdir` sets both attributes."""
_CODE = ("plugin", "extension")
"""Tags of elements that make MuJoCo execute plugins."""
_NAMED_BY_FILE = ("mesh", "hfield", "texture")


class _UnreadableError(Exception):
    """A file cannot be read; the message gives the reason."""


class Library:
    """The contents of the files of a scene: MJCF files in `models`, all others in `assets`.

    The contents have keys, which replace the file names in the XML for MuJoCo.

    Args:
        files: decides which files may be read, and records them.
        findings: receives errors and notes.
    """

    def __init__(self, files: Files, findings: Findings) -> None:
        self.files = files
        self.findings = findings
        self.assets: dict[str, bytes] = {}
        self.models: dict[str, bytes] = {}
        self._keys: dict[Path, str] = {}
        self._included_files: dict[Path, str] = {}
        """The files inserted by `include`, with symbolic links resolved, as keys; the values are empty."""
        self._meshes: dict[MeshKind, LoadedMesh] = {}
        self._textured: set[MeshKind] = set()
        """Meshes whose files use images."""
        self._plates: dict[tuple[str, str], str] = {}
        """Key of the mesh to use for a collider's file and scale: the file's own key, a plate's key, or empty for a line."""
        self.memory = 0.0
        """Estimated memory (see `bounds`) of the world and the robots in use, bytes."""
        self._read_bytes = 0
        """Size of all files that were read, bytes."""
        self._heaviest = 0.0
        """Estimated memory of the largest model that may be attached, bytes."""
        self._missing: list[MissingFile] = []
        """Unreported references to missing files."""
        self.outcomes: dict[str, Outcome] = {}
        """Result of loading each mesh of the descriptions, by reference."""

    def copy(self, files: Files) -> Library:
        """Return a copy that reads further files independently of this one."""
        made = copy.copy(self)
        made.files = files
        for name, value in vars(self).items():
            if isinstance(value, dict):
                setattr(made, name, dict(value))
        return made

    def world(self, path: Path, text: str | None = None) -> Element | None:
        """Read an MJCF file or text; return its root element, in which keys replace all file names, or None after an error.

        Args:
            path: path of the file; relative references start from its folder.
            text: text to parse instead of the file.
        """
        before = len(self.findings.errors)
        root = self._model(path, [], text)
        self._report_missing()
        return root if len(self.findings.errors) == before else None

    def read_files(self) -> list[Path]:
        """Return the files that models include or refer to, with symbolic links resolved."""
        return list(dict.fromkeys([*self._included_files, *self._keys]))

    def is_shipped(self, world: Path) -> bool:
        """Return whether a world and all files that were read ship with this package; a user's file may replace a shipped one."""
        folder = shipped()
        return all(path.is_relative_to(folder) for path in (world.resolve(), *self.read_files()))

    def source(self, key: str) -> Path | None:
        """Return the path of the file that has the given key in `assets` or `models`; None if there is no such file."""
        return next((path for path, known in self._keys.items() if known == key), None)

    def meshes(self, shapes: Sequence[tuple[Element, bool]], packages: Packages) -> dict[Element, list[MeshFile]]:
        """Load the meshes of a URDF description; return the mesh files that MuJoCo can read, for each `mesh` element.

        A converted visual mesh may have several files, one per colour. An unreadable visual mesh is left out with a note; an
        unreadable collider and a missing file are errors.

        Args:
            shapes: (`mesh` element, whether it belongs to a visual) for each mesh.
            packages: finds the files of references.
        """
        kinds: dict[Element, MeshKind] = {}
        for element, visual in shapes:
            reference = element.get("filename")
            self.outcomes[reference] = "missing"
            path = self._find(element, "filename", packages.places(reference), "S103", packages)
            if path is not None:
                kinds[element] = MeshKind(path.resolve(), path.suffix.lower(), visual)
        self._report_missing()
        known = {element: kind for element, kind in kinds.items() if kind.visual and kind not in self._meshes}
        self._load(dict.fromkeys(kind for kind in kinds.values() if kind not in self._meshes))
        found = {element: self._files(element, kind) for element, kind in kinds.items()}
        if textured := [element for element, kind in known.items() if kind in self._textured]:
            names = listing(dict.fromkeys(element.get("filename") for element in textured), "meshes")
            text = "textures of mesh files are not drawn; plain colours are"
            self.findings.add("N103", text, textured[0].place("filename"), names)
        return found

    def _report_missing(self) -> None:
        report_missing(self._missing, self.findings)
        self._missing = []

    def _files(self, element: Element, kind: MeshKind) -> list[MeshFile]:
        """Return the mesh files that replace a loaded mesh; if it is unreadable, add an error or a note."""
        reference, mesh = element.get("filename"), self._meshes[kind]
        self.outcomes[reference] = mesh.outcome
        if mesh.outcome == "unreadable":
            code, what = ("N103", "the visual {!r} is not drawn: {}") if kind.visual else ("S103", "{!r}: {}")
            self.findings.add(code, what.format(reference, mesh.why), element.place("filename"))
        return mesh.files if kind.visual else [each for file in mesh.files for each in self.solid(element, file)]

    def solid(self, element: Element, file: MeshFile) -> list[MeshFile]:
        """Return the mesh file of a collider, or a plate if the mesh is flat; nothing if all its vertices lie on one line."""
        use = file.key, element.get("scale", "1 1 1")
        if use not in self._plates:
            data = self.assets[file.key]
            thin = file.key.endswith(".msh") and is_flat(data, ".msh")
            plate = thickened(data, numbers(use[1], 3) or ()) if thin else None
            key = self.keep(f"{Path(file.key).stem}_plate.msh", plate) if plate is not None else ""
            self._plates[use] = key if thin else file.key
        key = self._plates[use]
        if key != file.key:
            flat = f"is flat: a plate of {THICKNESS * 1000:g} mm replaces it"
            text = f"the collider {element.get('filename')!r} {flat if key else 'has no area and is left out'}"
            self.findings.add("N103", text, element.place("filename"))
        return [MeshFile(key)] if key else []

    def _load(self, kinds: Iterable[MeshKind]) -> None:
        """Read mesh files, and convert all files that MuJoCo cannot read in a single process."""
        foreign: dict[MeshKind, Foreign] = {}
        for kind in sorted(kinds):  # the uses of a file as visual and as collider become neighbours
            try:
                data = self._mesh_data(kind)
            except _UnreadableError as error:
                self._meshes[kind] = LoadedMesh("unreadable", [], str(error))
                continue
            if meshes.has_textures(data, kind.suffix):
                self._textured.add(kind)
            foreign_format = meshes.needs_conversion(data, kind.suffix)
            if foreign_format or (not kind.visual and kind.suffix != ".msh" and is_flat(data, kind.suffix)):
                foreign[kind] = Foreign(data, kind.suffix, kind.visual)
                continue
            if kind.path not in self._keys:
                self._keys[kind.path] = self.keep(f"{kind.path.stem}{kind.suffix}", data)
            self._meshes[kind] = LoadedMesh("unchanged", [MeshFile(self._keys[kind.path])])
        if foreign:
            warn(self.findings)
        for kind, became in zip(foreign, convert_all(list(foreign.values())), strict=True):
            if isinstance(became, meshes.MeshError):
                self._meshes[kind] = LoadedMesh("unreadable", [], str(became))
            else:
                files = [MeshFile(self.keep(f"{kind.path.stem}.msh", part.data), part.colour) for part in became]
                self._meshes[kind] = LoadedMesh("converted", files)

    def _mesh_data(self, kind: MeshKind) -> bytes:
        if kind.path in self._keys:
            return self.assets[self._keys[kind.path]]
        if kind.suffix not in meshes.READABLE:
            legal = listing(meshes.READABLE)
            raise _UnreadableError(f"meshes of the format {kind.suffix!r} are not supported; {legal}")
        return self._content(kind.path)

    def weigh(self, root: Element, *, nested: bool = False) -> bool:
        """Add the estimated memory of a model to `memory`. If the sum exceeds the limit, add an error and return False.

        Args:
            root: root element of MJCF, in which keys replace file names.
            nested: whether the model may be attached to others; it is counted for each `attach`, instead of here.
        """
        memory, culprit = weigh(root, self._heaviest, self.assets, 0.0 if nested else self.memory)
        if culprit is not None:
            self._too_large(culprit, "S102")
        elif nested:
            self._heaviest = max(self._heaviest, memory)
        else:
            self.memory = memory
        return culprit is None

    def add_memory(self, parts: Iterable[tuple[Element, float]], code: str) -> bool:
        """Add the memory of a robot to `memory`. If the sum exceeds the limit, add an error and return False.

        Args:
            parts: elements of the robot's description, and the estimated memory of each, bytes.
            code: code of the error.
        """
        total = self.memory
        for element, memory in parts:
            total += memory
            if total > MAX_MEMORY:
                self._too_large(element, code)
                return False
        self.memory = total
        return True

    def _too_large(self, element: Element, code: str) -> None:
        what = f"at this <{element.tag}> the world and its robots {TOO_LARGE}"
        self.findings.add(code, what, element.span, *HOW_MEMORY_COUNTS)

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
                text = f"<{element.tag}>: MuJoCo plugins are not supported, because they execute native code"
                self.findings.add("S102", text, element.span, "remove this element")
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
        self.weigh(root, nested=bool(nested))
        return root

    def _include(self, element: Element, folder: Path, seen: list[Path], main: Path, depth: int) -> None:
        """Replace each `include` below an element by the content of its file; including a file twice is an error, as in MuJoCo.

        Args:
            element: element whose children are searched.
            folder: folder of the file that contains the element.
            seen: resolved paths of the files that were read; included files are appended.
            main: folder of the main file; included files are looked up there if `folder` does not have them.
            depth: depth of the element, 1 for the root.
        """
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
        """Read the file that an attribute names, and replace the name by the file's key in `models` or `assets`."""
        reference = element.get(attribute)
        if not reference:
            del element.attributes[attribute]
            return
        if element.tag in _NAMED_BY_FILE:
            element.attributes.setdefault("name", Path(reference).stem)
        folder = main / folders.get(_FOLDERS.get(element.tag, ""), "")
        path = self._find(element, attribute, [folder / reference], "S102")
        try:
            if path is not None and element.tag == "model":
                self._add_model(path, nested)
            elif path is not None and path.resolve() not in self._keys:
                self._keys[path.resolve()] = self.keep(path.name, self._content(path.resolve()))
        except _UnreadableError as error:
            self.findings.add("S102", f"{reference!r}: {error}", element.place(attribute))
        if path is not None:
            element.attributes[attribute] = self._keys.get(path.resolve(), "")

    def _add_model(self, path: Path, nested: list[Path]) -> None:
        """Add an MJCF file to `models`, unless it has errors.

        Raises:
            _UnreadableError: the file is one of the files `nested` around it.
        """
        resolved = path.resolve()
        if resolved in nested:
            raise _UnreadableError("the model contains itself")
        if resolved not in self._keys and (root := self._model(path, nested)) is not None:
            self._keys[resolved] = f"model{len(self.models)}.xml"
            self.models[self._keys[resolved]] = write(root)[0].encode()

    def keep(self, name: str, data: bytes) -> str:
        """Add an asset and return its key, which keeps the suffix of the name, because MuJoCo infers the format from it."""
        key = f"{len(self.assets)}_{name}"
        self.assets[key] = data
        return key

    def _content(self, path: Path) -> bytes:
        """Return the content of a file.

        Raises:
            _UnreadableError: the file cannot be read, or exceeds a limit.
        """
        try:
            with open_regular(path) as file:
                data = file.read(MAX_FILE_BYTES + 1)
        except OSError as error:
            raise _UnreadableError(f"the file cannot be read: {error.strerror or error}") from None
        if len(data) > MAX_FILE_BYTES:
            raise _UnreadableError(f"the file is larger than {MAX_FILE_BYTES // 1_000_000} MB")
        self._read_bytes += len(data)
        if self._read_bytes > MAX_FILES_BYTES:
            limit = MAX_FILES_BYTES // 1_000_000
            raise _UnreadableError(f"with this file, the files of the scene are larger than {limit} MB")
        return data

    def _find(
        self, element: Element, attribute: str, places: list[Path], code: str, packages: Packages | None = None
    ) -> Path | None:
        reference, span = element.get(attribute), element.place(attribute)
        try:
            readable = [place for place in places if self.files.may_read(place)]
            found = next((place for place in readable if self._is_there(place)), None)
            outside = package_folder(places[0]) if places and not readable else None
        except (OSError, RuntimeError, ValueError) as error:  # a name that is too long, or a loop of symbolic links
            self.findings.add(code, f"cannot look up {reference[:200]!r}: {error}", span)
            return None
        if found is not None:
            self.files.note(found)
            return found
        if outside is not None:
            what = f"{reference!r} lies outside the folder of the file you gave"
            self.findings.add(code, what, span, allowing(outside))
            return None
        self._missing.append(MissingFile(element, attribute, readable, packages))
        return None

    def _is_there(self, place: Path) -> bool:
        if place.is_file():
            return True
        self.files.note_missing(place)
        return False
