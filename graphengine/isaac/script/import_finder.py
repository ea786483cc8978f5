"""Import hook for scripts: Python's modules, modules in the script's folder, and stubs for all others."""

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
"""Modules that a script gets as they are; of others that do not lie beside it there are stubs."""

_ABOVE = "above"
PACKAGE = f"{_ABOVE}.{_ABOVE}.{_ABOVE}.{_ABOVE}.beside"
"""The package that a script is in, for its relative imports; those above it are stubs if they may not be read."""
MAX_ABOVE = 5
"""Folders above a script in which modules are looked for that may not be read yet."""


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
        """Return the spec of a stub package, whose submodules may be files."""
        spec = ModuleSpec(name, self, is_package=True)
        spec.submodule_search_locations = list(places)
        return spec

    def _package(self, name: str) -> ModuleSpec:
        """Return the script's own package or a package above it; `__init__.py` runs if its folder may be read."""
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
        """Return how to make a module above the script readable."""
        for folder in Path(self.folders[0]).parents[:MAX_ABOVE]:
            if (folder / name).is_dir() or (folder / f"{name}.py").is_file():
                yield f"--allow {folder} lets it be imported"
                return

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        """Return the known module, or a stub."""
        return self.modules.get(spec.name) or StubModule(_known(spec.name), self.recorder, self.modules)

    def exec_module(self, module: types.ModuleType) -> None:
        """Do nothing, because the module is complete."""


def _known(name: str) -> str:
    """Return the name of a module as written in the script."""
    return name.rpartition(f"{_ABOVE}.")[2]
