"""Opens the layers of a stage, and removes references to files that may not be read; runs in the confined process.

USD opens referenced files in native code, which audit hooks do not see. Therefore each layer is opened separately, and
references to forbidden files are removed from it in memory, before USD composes the stage.
"""

from __future__ import annotations

import os
from pathlib import Path

from pxr import Sdf, Tf

from graphengine.format.files import Files
from graphengine.format.wording import allowing
from graphengine.isaac.stage.stage_contents import PLACE, SUFFIXES

MAX_BYTES = 256_000_000
"""Maximum size of all layers of a stage together, bytes; a robot with meshes has 10 MB to 100 MB."""
MAX_LAYERS = 1000
"""Maximum number of files of a USD stage."""


class UnreadableError(Exception):
    """A layer cannot be opened, or may not be read; the message gives the reason."""


class Layers:
    """The layers of a stage that were opened, and the references that were removed.

    Args:
        files: decides which files may be read.
    """

    def __init__(self, files: Files) -> None:
        self.files = files
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
                    layer.UpdateCompositionAssetDependency(reference, "")
                    named = "" if layer == root else f"; {layer.GetDisplayName()} refers to it"
                    self.left_out.append((reference, f"{error}{named}"))
        return root

    def holds(self, layer: Sdf.Layer) -> bool:
        """Return whether this object opened the layer."""
        return bool(self._opened.get(layer.identifier) == layer)

    def _follow(self, layer: Sdf.Layer, reference: str) -> None:
        """Open the layer to which a reference in `layer` points; raise UnreadableError if it cannot be opened."""
        name, arguments = Sdf.Layer.SplitIdentifier(reference)
        if "://" in name:
            raise UnreadableError("it is not a local file")
        if "`" in name or arguments:
            raise UnreadableError("its name contains an expression or arguments")
        absolute = layer.ComputeAbsolutePath(name)
        if not os.path.isabs(absolute):
            raise UnreadableError("the file does not exist")
        self._open(absolute)

    def _open(self, path: str) -> Sdf.Layer:
        known = Sdf.Layer.Find(path)
        if known is not None and self.holds(known):
            return known
        if not self.files.may_read(Path(path)):
            remedy = allowing(Path(path).resolve().parent)
            raise UnreadableError(f"it lies outside the folder of the file you gave; {remedy}")
        if not os.path.isfile(path):
            raise UnreadableError("the file does not exist")
        if os.path.splitext(path)[1].lower() not in SUFFIXES:
            raise UnreadableError("it is not a .usd, .usda or .usdc file")
        if len(self._opened) >= MAX_LAYERS:
            raise UnreadableError(f"the stage has more than {MAX_LAYERS} files")
        self._bytes += os.path.getsize(path)
        if self._bytes > MAX_BYTES:
            raise UnreadableError(f"the files of the stage are together larger than {MAX_BYTES // 1_000_000} MB")
        try:
            layer = Sdf.Layer.FindOrOpen(path)
        except Tf.ErrorException as error:
            raise UnreadableError(reason(error)) from None
        if layer is None:
            raise UnreadableError("USD cannot open it as a stage")
        self.files.note(Path(path))
        self._opened[layer.identifier] = layer
        self._pending.append(layer)
        return layer


def reason(error: Tf.ErrorException) -> str:
    """Return the message of a USD error; if it has several, the first one that begins with a position in a file."""
    texts = [str(one.commentary).strip("'\n") for one in error.args]
    return next((text for text in texts if PLACE.match(text)), texts[0] if texts else "USD gives no reason")


def _drop_clips(layer: Sdf.Layer) -> None:
    """Remove the value clips of all prims in a layer: USD would open their files, but graphs use no time samples."""

    def visit(path: Sdf.Path) -> None:
        prim = layer.GetPrimAtPath(path) if path.IsPrimPath() or path.IsPrimVariantSelectionPath() else None
        if prim is not None and prim.HasInfo("clips"):
            prim.ClearInfo("clips")

    layer.Traverse(Sdf.Path.absoluteRootPath, visit)
