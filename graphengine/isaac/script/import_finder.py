"""Import hook for scripts: finds Python's modules and modules in the script's folder, and makes stubs for all others."""

from __future__ import annotations

import importlib.abc
import importlib.util
import os
import types
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from typing import Any

from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.modules import ROOTS
from graphengine.isaac.omniverse.stubs import StubModule

OFFERED = (
    "abc argparse ast base64 bisect collections collections.abc contextlib copy csv dataclasses datetime decimal "
    "enum errno fractions functools glob hashlib heapq importlib importlib.util inspect io itertools json logging "
    "math numbers operator os os.path pathlib platform pprint pwd random re shutil signal statistics string "
    "struct sys tempfile textwrap threading time traceback types typing typing_extensions uuid warnings weakref "
    "yaml"
)
"""Python modules that a script can import; modules beside the script can be imported too, all others are stubs."""

_ABOVE = "above"
PACKAGE = f"{_ABOVE}.{_ABOVE}.{_ABOVE}.{_ABOVE}.beside"
"""Package name of the script, for its relative imports; parent packages are stubs if their folders may not be read."""
MAX_ABOVE = 5
"""Number of folders above a script that are searched for a missing module, to suggest `--allow`."""


class ImportFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds the modules that a script imports.

    Args:
        recorder: receives notes on modules that are not imported.
        modules: known modules by name.
        folders: readable folders; the first one contains the script.
    """

    def __init__(self, recorder: GraphRecorder, modules: Mapping[str, Any], folders: Sequence[str]) -> None:
        self.recorder, self.modules, self.folders = recorder, modules, folders

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a known module, of a file in the folders, or of a stub."""
        if f"{PACKAGE}.".startswith(f"{name}."):
            return self._package(name)
        if name not in self.modules and name.partition(".")[0] not in ROOTS:
            beside = PathFinder.find_spec(name, self.folders if path is None else list(path))
            if beside is not None:
                return beside if beside.loader else self._stub(name, beside.submodule_search_locations or ())
            known = _known(name)
            if "." not in known:
                place = self.recorder.where(known)
                self.recorder.lacking.add(known)
                self.recorder.findings.add("N302", f"module {known!r} is not imported", place, *self._remedy(known))
        return self._stub(name)

    def _stub(self, name: str, places: Sequence[str] = ()) -> ModuleSpec:
        """Return the spec of a stub package; `places` are folders with real submodules."""
        spec = ModuleSpec(name, self, is_package=True)
        spec.submodule_search_locations = list(places)
        return spec

    def _package(self, name: str) -> ModuleSpec:
        """Return the spec of the script's package or one above it; a stub without a readable `__init__.py`."""
        up = PACKAGE.count(".") - name.count(".")
        folder = os.path.normpath(os.path.join(self.folders[0], *[os.pardir] * up))
        if not any(os.path.commonpath((folder, root)) == root for root in self.folders):
            return self._stub(name)
        start = os.path.join(folder, "__init__.py")
        if os.path.isfile(start):
            found = importlib.util.spec_from_file_location(name, start, submodule_search_locations=[folder])
            if found is not None:
                return found
        return self._stub(name, [folder])

    def _remedy(self, name: str) -> Iterator[str]:
        """Yield the option that makes a module in a folder above the script readable, if there is such a module."""
        for folder in Path(self.folders[0]).parents[:MAX_ABOVE]:
            if (folder / name).is_dir() or (folder / f"{name}.py").is_file():
                yield f"to import it, add --allow {folder}"
                return

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        """Return the known module, or a stub."""
        return self.modules.get(spec.name) or StubModule(_known(spec.name), self.recorder, self.modules)

    def exec_module(self, module: types.ModuleType) -> None:
        """Do nothing, because the module is complete."""


def _known(name: str) -> str:
    """Return a module's name as in the script, without the internal package prefix of relative imports."""
    return name.rpartition(f"{_ABOVE}.")[2]
