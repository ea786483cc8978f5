"""Reads SDF files and the models that they include, from allowed folders and within limits on size and depth.

`model://NAME` refers to a folder NAME in the folders around the file or in the folders that the user allows. Nothing is
downloaded.
"""

from __future__ import annotations

import os
import posixpath
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import unquote

from graphengine.descriptions.files.packages import Packages, package_of
from graphengine.descriptions.files.xml import MAX_ELEMENTS, Element, parse, read
from graphengine.descriptions.sdf.sdf_frames import Scope, SdfFrame
from graphengine.descriptions.sdf.sdf_values import SdfError, leaf, reported, text_at
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import allowing, listing, printable

SUFFIXES = (".sdf", ".world")
TAG = "sdf"
"""Tag of the root element of an SDF file."""
CONFIG = "model.config"
"""Name of the file in a model's folder that names the SDF files of the model."""
OLDEST, NEWEST = 4, 12
"""Minor numbers of the oldest and the newest supported version of SDF (1.4 and 1.12)."""
MAX_DEPTH = 20
"""Maximum number of levels of nested models."""
MAX_MODELS = 5000
"""Maximum number of models of an SDF file, including models of included files."""
MAX_URI = 1000
"""Maximum number of characters of the URI in an include."""
_MAX_MISSING = 50
"""Maximum number of missing models; if there are more, no further models are searched."""
_MAX_NEIGHBOURS = 1000
"""Maximum number of folders beside a file that are searched for a model."""
_VERSION = re.compile(r"1\.(\d{1,3})(?:\.\d+)?")
_FUEL = re.compile(r"https?://[^/]+/.*/models/([^/]+)(?:/(?:\d+|tip))?(/files/.*)?/?")
"""Matches the URL of a model on Gazebo Fuel; the groups are the model's name and a path in the model."""

SUN = """<sdf version="1.6"><light type="directional" name="sun">
<pose>0 0 10 0 0 0</pose><diffuse>0.8 0.8 0.8 1</diffuse><specular>0.2 0.2 0.2 1</specular>
<direction>-0.5 0.1 -0.9</direction><cast_shadows>true</cast_shadows></light></sdf>"""
GROUND_PLANE = """<sdf version="1.6"><model name="ground_plane"><static>true</static><link name="link">
<collision name="collision"><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry></collision>
<visual name="visual"><geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
<material><diffuse>0.5 0.5 0.5 1</diffuse></material></visual></link></model></sdf>"""
_BUILT_IN = {"sun": SUN, "ground_plane": GROUND_PLANE}
"""Texts of Gazebo models that most worlds include, by name; a text is used if no folder contains the model."""


@dataclass(frozen=True, slots=True)
class _File:
    """An SDF file.

    Attributes:
        root: the `<sdf>` element of the file.
        version: minor number of the file's SDF version.
        path: path of the file, with symbolic links resolved; None for a built-in model.
        references: prefix that makes the file's relative references relative to the folder of the main file.
    """

    root: Element
    version: int
    path: Path | None
    references: str


def is_sdf(root: Element) -> bool:
    """Return whether an XML document is SDF."""
    return root.tag == TAG


def model_folders(path: Path) -> list[Path]:
    """Return the folder of the model to which a file belongs, then the folders of neighbouring models.

    A model's folder contains a `model.config`. The list is empty if no folder around the file contains one.
    """
    own = next((folder for folder in path.absolute().parents if (folder / CONFIG).is_file()), None)
    if own is None:
        return []
    try:
        with os.scandir(own.parent) as entries:
            beside = sorted(entry.path for entry, _ in zip(entries, range(_MAX_NEIGHBOURS), strict=False))
    except OSError:
        beside = []
    return [own, *(Path(folder) for folder in beside if Path(folder) != own and Path(folder, CONFIG).is_file())]


class SdfFiles:
    """Reads the SDF files of one description; each file is parsed once.

    Args:
        packages: resolve `model://`, and decide which files may be read.
        findings: receives errors and notes.
    """

    def __init__(self, packages: Packages, findings: Findings) -> None:
        self.packages = packages
        self.findings = findings
        self._parsed: dict[Path, Element | None] = {}
        self._elements = 0
        self._models = 0
        self._missing = 0
        self._enough: SdfError | None = None

    def main(self, path: Path, root: Element) -> _File:
        """Return the parsed main file of the description as an SDF file.

        Raises:
            SdfError: the file's version of SDF is not supported.
        """
        return _File(root, _version(root), path.resolve(), "")

    def scope(self, element: Element, file: _File) -> Scope:
        """Read a model or a world of a file, with all models that it includes; return it as a scope of names.

        Raises:
            SdfError: there are too many models, or they are nested too deeply.
        """
        name = element.get("name") or "model"
        return self._scope(element, name, file, None, [file.path] if file.path else [])

    def _scope(self, element: Element, name: str, file: _File, outer: Scope | None, stack: list[Path]) -> Scope:
        depth, around = 0, outer
        while around is not None:
            depth, around = depth + 1, around.outer
        self._models += 1
        if depth > MAX_DEPTH or self._models > MAX_MODELS:
            limit = f"{MAX_DEPTH} levels deep" if depth > MAX_DEPTH else f"{MAX_MODELS} models"
            raise SdfError(f"too many nested models: more than {limit}", element.span)
        made = Scope(element, name, file.version, outer, file.references)
        named = {"link": made.links, "joint": made.joints, "frame": made.frames}
        for child in element.children:
            if child.tag in named:
                self._add(named[child.tag], child, made)
            elif child.tag == "model":
                self._add_model(made, self._scope(child, child.get("name"), file, made, stack))
            elif child.tag == "include":
                with reported(self.findings):
                    self._include(child, made, file, stack)
        made.index()
        return made

    def _add(self, named: dict[str, SdfFrame], element: Element, scope: Scope) -> None:
        name = element.get("name")
        if not name:
            self.findings.add("S103", f"a {element.tag} without a name", element.span)
        elif name in named:
            first = [(named[name].element.span, "first here")]
            text = f"two {element.tag}s named {printable(name)!r}"
            self.findings.add("S105", text, element.place("name"), related=first)
        else:
            named[name] = SdfFrame(element.tag, name, element, scope)

    def _add_model(self, outer: Scope, scope: Scope) -> None:
        name = scope.name
        if name in outer.models:
            first = [(outer.models[name].element.span, "first here")]
            self.findings.add("S105", f"two models named {printable(name)!r}", scope.element.span, related=first)
        else:
            outer.models[name] = scope

    def _include(self, include: Element, outer: Scope, file: _File, stack: list[Path]) -> None:
        uri = include.first("uri")
        if uri is None or not 0 < len(uri.text) <= MAX_URI:
            raise SdfError(f"an include without <uri>, or with one longer than {MAX_URI} characters", include.span)
        found = self._find(uri.text, file, uri.span)
        if found.path is not None and found.path in stack:
            raise SdfError(f"the model {printable(uri.text)!r} includes itself", uri.span)
        loaded = next((child for child in found.root.children if child.tag in ("model", "light", "actor")), None)
        if loaded is None:
            raise SdfError(f"the file of {printable(uri.text)!r} has no <model>", uri.span)
        self._elements += sum(1 for _ in loaded.walk())
        if self._elements > MAX_ELEMENTS:
            raise SdfError(f"with its includes, the file has more than {MAX_ELEMENTS} elements", include.span)
        made = _overridden(loaded, include)
        if loaded.tag != "model":
            outer.element = replace(outer.element, children=[*outer.element.children, made])
            return
        inner = [*stack, found.path] if found.path is not None else stack
        scope = self._scope(made, made.get("name"), found, outer, inner)
        if include.get("merge").lower() in ("true", "1"):
            scope.merged = True
            outer.merges.append(scope)
        else:
            self._add_model(outer, scope)

    def _find(self, uri: str, file: _File, span: Span) -> _File:
        """Return the SDF file to which the URI of an include refers.

        Raises:
            SdfError: the file is not found, may not be read, or is not SDF.
        """
        if self._enough is not None:
            raise self._enough
        name, places = self._places(uri, file)
        if name is not None and not places and (text := _BUILT_IN.get(name.lower().replace(" ", "_"))):
            root = parse(text.encode(), f"model://{name}", self.findings, "S103")
            assert root is not None
            return _File(root, _version(root), None, "")
        for place, references in places:
            for path in _model_files(place) if self._may_read(place) else ():
                if self._may_read(path) and path.is_file():
                    # The folder of the file, relative to the place that the URI names.
                    inside = os.path.relpath(path.parent, place) if path != place else ".."
                    scheme, separator, folder = references.rpartition("://")
                    folder = posixpath.normpath(posixpath.join(folder, inside))
                    return self._read(path, f"{scheme}{separator}{folder}", span)
        self._missing += 1
        if self._missing > _MAX_MISSING:  # each search may visit thousands of folders
            text = f"more than {_MAX_MISSING} models are not found; further models are not searched"
            self._enough = SdfError(text, span)
        outside = next((str(place) for place, _ in places if place.exists() and not self._may_read(place)), None)
        if outside is not None:
            what = f"{printable(uri[:200])!r} lies outside the folder of the file you gave"
            raise SdfError(what, span, allowing(outside))
        searched = listing(self.packages.searched(), "looked in")
        advice = (
            "name the folder of the models by --package-path on import, package_paths in the robot file, or --allow"
        )
        if uri.startswith("http") and name is not None:
            advice = f"nothing is downloaded: put the folder {printable(name)!r} beside the file, or name it by --allow"
        elif "://" in uri and name is None:
            searched, advice = "", "write model://NAME, file:// or a path; nothing is downloaded"
        raise SdfError(f"no model {printable(uri[:200])!r}", span, searched, advice)

    def _may_read(self, path: Path) -> bool:
        return self.packages.files.may_read(path)

    def _places(self, uri: str, file: _File) -> tuple[str | None, list[tuple[Path, str]]]:
        """Return the name of the model in a URI, and (path, prefix of relative references) of each possible place.

        The name is None for file URIs and unsupported schemes.
        """
        folder = file.path.parent if file.path is not None else self.packages.folder
        fuel = _FUEL.fullmatch(uri)
        if fuel is not None or (name := package_of(uri)) is not None:
            rest = uri.partition("://")[2].lstrip("/").partition("/")[2] if fuel is None else ""
            name = unquote(fuel[1]) if fuel is not None else name
            found = self.packages.find(name) if name else None
            return name, [(found / rest, f"model://{name}/{rest}")] if found is not None else []
        if uri.startswith("file://"):
            path = folder / unquote(uri.removeprefix("file://"))
            return None, [(path, path.as_uri() if path.is_absolute() else "")]
        if "://" in uri:
            return None, []
        relative = os.path.relpath(folder / uri, self.packages.folder.resolve())
        found = self.packages.find(uri) if "/" not in uri and not (folder / uri).exists() else None
        return uri, [(folder / uri, relative), *([(found, f"model://{uri}")] if found is not None else [])]

    def _read(self, path: Path, references: str, span: Span) -> _File:
        resolved = path.resolve()
        if resolved not in self._parsed:
            self.packages.files.note(path)
            self._parsed[resolved] = read(path, self.findings, "S103")
        root = self._parsed[resolved]
        if root is None:
            raise SdfError(f"{printable(str(path))!r} cannot be read", span)
        if not is_sdf(root):
            text = f"{printable(str(path))!r} begins with <{root.tag[:40]}>; an included file must be SDF"
            raise SdfError(text, span)
        return _File(root, _version(root), resolved, f"{references}/")


def _version(root: Element) -> int:
    """Return the minor number of the SDF version of a file.

    Raises:
        SdfError: the version is missing or not supported.
    """
    text = root.get("version")
    if not (version := _supported(text)):
        legal = f"supported versions: 1.{OLDEST} to 1.{NEWEST}"
        what = f"SDF version {printable(text[:20])!r} is not supported" if text else "SDF file without a version"
        raise SdfError(what, root.place("version"), legal)
    return version


def _model_files(place: Path) -> Iterator[Path]:
    """Yield the paths of SDF files to which a path may refer, most likely first.

    A folder refers to the files that its `model.config` names, newest supported version first, then to `model.sdf`.
    """
    if not place.is_dir():
        yield place
        return
    config = place / CONFIG
    root = read(config, Findings(), "S103") if config.is_file() and not config.is_symlink() else None
    named = root.all(TAG) if root is not None else []
    for element in sorted(named, key=lambda element: _supported(element.get("version")), reverse=True):
        if element.text:
            yield place / element.text
    yield place / "model.sdf"


def _supported(version: str) -> int:
    """Return the minor number of a version of SDF; 0 if the version is not supported."""
    found = _VERSION.fullmatch(version)
    return int(found[1]) if found is not None and OLDEST <= int(found[1]) <= NEWEST else 0


def _overridden(loaded: Element, include: Element) -> Element:
    """Return an included model or light with the changes in the `include`: name, pose, `static` and added plugins."""
    attributes = {**loaded.attributes, "name": text_at(include, "name") or loaded.get("name")}
    if name := text_at(include, "placement_frame"):
        attributes["placement_frame"] = name
    given = [child for child in include.children if child.tag in ("pose", "static") and child.text]
    tags = {child.tag for child in given}
    children = [*given, *(child for child in loaded.children if child.tag not in tags), *include.all("plugin")]
    if "experimental:params" in {child.tag for child in include.children}:
        children.append(leaf("params", "changes of an included model", include.span))
    return Element(loaded.tag, attributes, loaded.span, children, loaded.text)
