"""Opens the layers of a stage, and removes references to files that may not be read; runs in the confined process.

USD opens referenced files in native code, which audit hooks do not see. Therefore each layer is opened separately, and
references to forbidden files are removed from it in memory, before USD composes the stage.
"""

from __future__ import annotations

import os
import posixpath
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

import pxr
from pxr import Ar, Sdf, Tf, Usd, Work

from graphengine.descriptions.usd.stage_files import PLACE, SUFFIXES
from graphengine.format.files import Files
from graphengine.format.wording import allowing
from graphengine.sandbox.confinement import confine
from graphengine.sandbox.seccomp import TIERS
from graphengine.sandbox.untrusted import reply

MAX_BYTES = 256_000_000
"""Maximum size of all layers of a stage together, bytes; a robot with meshes has 10 MB to 100 MB."""
MAX_LAYERS = 1000
"""Maximum number of files of a USD stage."""
MAX_MEMORY_BYTES = 4 << 30
"""Memory limit of the process, bytes; USD needs about 30 times the size of a text file."""
MOST_CHOICES = 20
"""Maximum number of variant selections that are reported."""
_MOST_USERS = 3
"""Maximum number of prims that a message names for a file that they need."""


class UnreadableError(Exception):
    """A layer cannot be opened, or may not be read; the message gives the reason."""


def confined(files: Files) -> IO[str]:
    """Confine this process permanently to the files that may be read, and return the stream for its answer."""
    stream = reply()
    Work.SetConcurrencyLimit(1)  # each thread needs part of the limited memory
    confine(files, TIERS["stage"], memory=MAX_MEMORY_BYTES, libraries=(Path(pxr.__file__).parent,))
    return stream


def open_stage(
    path: Path,
    files: Files,
    variants: Mapping[str, str] | None = None,
    replaced: Mapping[str, str] | None = None,
    mirrors: Sequence[str] = (),
) -> tuple[Usd.Stage, list[tuple[str, str]]]:
    """Open a stage; return it, and pairs (reference, reason) of the references that were removed.

    Args:
        path: file of the stage.
        files: decides which files may be read.
        variants: variants to select, as pairs PRIM:SET or SET, and the name of the variant.
        replaced: files in place of assets, by the reference to the asset.
        mirrors: folders with copies of assets on servers.

    Raises:
        UnreadableError: the stage cannot be read, or has no such variant.
    """
    layers = Layers(files, replaced, [*map(Path, mirrors)])
    stage = Usd.Stage.Open(layers.open_all(path))
    strangers = [used.identifier for used in stage.GetUsedLayers() if not (used.anonymous or layers.holds(used))]
    if strangers:
        raise UnreadableError(f"it refers to {strangers[0]!r} in an unsupported way")
    _select(stage, variants or {})
    return stage, layers.left_out


def _select(stage: Usd.Stage, variants: Mapping[str, str]) -> None:
    """Select the variants that the user names, in the session layer of the stage."""
    stage.SetEditTarget(stage.GetSessionLayer())
    for key, name in variants.items():
        place, _, wanted = key.rpartition(":")
        prims = [stage.GetPrimAtPath(place)] if place and Sdf.Path.IsValidPathString(place) else stage.Traverse()
        found = [prim for prim in list(prims) if prim and wanted in prim.GetVariantSets().GetNames()]
        known = sorted({each for prim in found for each in prim.GetVariantSet(wanted).GetVariantNames()})
        if name not in known:
            what = f"known: {', '.join(known)[:300]}" if found else "no prim has this variant set"
            raise UnreadableError(f"it has no variant {key}={name}; {what}")
        for prim in found:
            prim.GetVariantSet(wanted).SetVariantSelection(name)


def variants_of(prim: Usd.Prim, choices: list[str]) -> None:
    """Add the variant selections of a prim to `choices`, as text with the available variants."""
    for name in prim.GetVariantSets().GetNames()[: MOST_CHOICES - len(choices)]:
        variants = prim.GetVariantSet(name)
        known = ", ".join(variants.GetVariantNames())
        choices.append(f"{prim.GetPath()}: {name} = {variants.GetVariantSelection()}, of {known}")


class Layers:
    """The layers of a stage that were opened, and the references that were removed.

    Args:
        files: decides which files may be read.
        replaced: files in place of assets, by the reference to the asset.
        mirrors: folders with copies of assets on servers.
    """

    def __init__(self, files: Files, replaced: Mapping[str, str] | None = None, mirrors: Sequence[Path] = ()) -> None:
        self.files = files
        self.replaced = replaced or {}
        self.mirrors = mirrors
        self.left_out: list[tuple[str, str]] = []
        """Pairs (reference, reason) of the removed references, in order of removal."""
        self._opened: dict[str, Sdf.Layer] = {}
        """Opened layers by identifier; they stay open, so that USD composes them and does not read the files again."""
        self._pending: list[Sdf.Layer] = []
        self._bytes = 0

    def open_all(self, path: Path) -> Sdf.Layer:
        """Open a layer and all layers to which it refers, directly or indirectly; return the layer.

        References to layers that cannot be opened are removed.

        Raises:
            UnreadableError: the layer itself cannot be opened.
        """
        root = self._open(os.path.realpath(path))  # references are relative to the file, not to a link to it
        while self._pending:
            layer = self._pending.pop()
            _drop_clips(layer)
            for reference in filter(None, layer.GetCompositionAssetDependencies()):  # "" refers to the layer itself
                try:
                    self._follow(layer, reference)
                except UnreadableError as error:
                    named = f"; needed by {', '.join(users)}" if (users := _users(layer, reference)) else ""
                    layer.UpdateCompositionAssetDependency(reference, "")
                    named += "" if layer == root else f"; {layer.GetDisplayName()} refers to it"
                    self.left_out.append((reference, f"{error}{named}"))
        return root

    def holds(self, layer: Sdf.Layer) -> bool:
        """Return whether this object opened the layer."""
        return bool(self._opened.get(layer.identifier) == layer)

    def _follow(self, layer: Sdf.Layer, reference: str) -> None:
        """Open the layer to which a reference in `layer` points; raise UnreadableError if it cannot be opened."""
        name, arguments = Sdf.Layer.SplitIdentifier(reference)
        local = self.replaced.get(reference) or (self._mirrored(name) if "://" in name else "")
        if local:
            layer.UpdateCompositionAssetDependency(reference, local)
            self._open(local)
            return
        if "://" in name:
            raise UnreadableError("it is on a server, which is never asked")
        if "`" in name or arguments:
            raise UnreadableError("its name contains an expression or arguments")
        absolute = layer.ComputeAbsolutePath(name)
        if not os.path.isabs(absolute):
            raise UnreadableError("the file does not exist")
        package = Ar.SplitPackageRelativePathOuter(absolute)[0] if Ar.IsPackageRelativePath(absolute) else ""
        if package and not any(each.realPath == package for each in self._opened.values()):
            self._check(package)
        self._open(absolute, inside=bool(package))

    def _mirrored(self, name: str) -> str:
        """Return the path of the copy of an asset on a server; empty without one.

        A mirror may have all folders of the asset's path, or only the last ones.
        """
        parts = posixpath.normpath(name.partition("://")[2]).split("/")
        copies = (folder.joinpath(*parts[start:]) for folder in self.mirrors for start in range(len(parts)))
        return next((str(copy) for copy in copies if ".." not in parts and copy.is_file()), "")

    def _open(self, path: str, *, inside: bool = False) -> Sdf.Layer:
        """Open a layer; `inside` is whether it is a file of a package that is open."""
        known = Sdf.Layer.Find(path)
        if known is not None and self.holds(known):
            return known
        if not inside:
            self._check(path)
        if len(self._opened) >= MAX_LAYERS:
            raise UnreadableError(f"the stage has more than {MAX_LAYERS} files")
        try:
            layer = Sdf.Layer.FindOrOpen(path)
        except (Tf.ErrorException, UnicodeDecodeError) as error:
            raise UnreadableError(reason(error)) from None
        if layer is None:
            raise UnreadableError("USD cannot open it as a stage")
        if not inside:
            self.files.note(Path(path))
        self._opened[layer.identifier] = layer
        self._pending.append(layer)
        return layer

    def _check(self, path: str) -> None:
        """Raise UnreadableError if a file may not be read, or is none of a stage, or too large."""
        if not self.files.may_read(Path(path)):
            remedy = allowing(Path(path).resolve().parent)
            raise UnreadableError(f"it lies outside the folder of the file you gave; {remedy}")
        if not os.path.isfile(path):
            raise UnreadableError("the file does not exist")
        if os.path.splitext(path)[1].lower() not in SUFFIXES:
            raise UnreadableError("it is not a .usd, .usda, .usdc or .usdz file")
        self._bytes += os.path.getsize(path)
        if self._bytes > MAX_BYTES:
            raise UnreadableError(f"the files of the stage are together larger than {MAX_BYTES // 1_000_000} MB")


def reason(error: Tf.ErrorException | UnicodeDecodeError) -> str:
    """Return the message of a USD error; if it has several, the first one that begins with a position in a file."""
    if isinstance(error, UnicodeDecodeError):
        return "it has text that is not UTF-8"
    texts = [str(one.commentary).strip("'\n") for one in error.args]
    return next((text for text in texts if PLACE.match(text)), texts[0] if texts else "USD gives no reason")


def _drop_clips(layer: Sdf.Layer) -> None:
    """Remove the value clips of all prims in a layer: USD would open their files, but graphs use no time samples."""

    def visit(path: Sdf.Path) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if prim is not None and prim.HasInfo("clips"):
            prim.ClearInfo("clips")

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)


def _users(layer: Sdf.Layer, reference: str) -> list[str]:
    """Return the paths of some prims of a layer that refer to a file."""
    found: list[str] = []

    def visit(path: Sdf.Path) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if prim is None or len(found) == _MOST_USERS:
            return
        items = [*prim.referenceList.GetAddedOrExplicitItems(), *prim.payloadList.GetAddedOrExplicitItems()]
        if any(item.assetPath == reference for item in items):
            found.append(str(path))

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
    return found
