"""Import hook for scripts: finds modules in readable folders, and creates stubs for all modules that are not loaded."""

from __future__ import annotations

import importlib.abc
import importlib.util
import os
import types
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from typing import Any

from graphengine.format.wording import quoted
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
"""Python modules that are loaded before the script runs, so that the script can import them."""

_ABOVE = "above"
PACKAGE = f"{_ABOVE}.{_ABOVE}.{_ABOVE}.{_ABOVE}.beside"
"""Package name that is given to the script; its four parent packages let relative imports reach folders above the script."""
MAX_ABOVE = 5
"""Number of folders above the script that are searched for a missing module, so that a finding can suggest `--allow`."""


class ImportFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds the modules that a script imports.

    Args:
        recorder: receives notes on modules that are not imported.
        modules: stubs that record calls, by module name.
        folders: readable folders; the first one contains the script.
    """

    def __init__(self, recorder: GraphRecorder, modules: Mapping[str, Any], folders: Sequence[str]) -> None:
        self.recorder, self.modules, self.folders = recorder, modules, folders

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return the spec of a stub module, of a module in the readable folders, or of a part of the script's package."""
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
        """Return the spec of a stub package; `places` are folders in which its submodules are found."""
        spec = ModuleSpec(name, self, is_package=True)
        spec.submodule_search_locations = list(places)
        return spec

    def _package(self, name: str) -> ModuleSpec:
        """Return the spec of the script's package or a parent package: its `__init__.py`, if that may be read, or a stub."""
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
        """Yield advice to add `--allow FOLDER`, if a folder above the script contains the module."""
        for folder in Path(self.folders[0]).parents[:MAX_ABOVE]:
            if (folder / name).is_dir() or (folder / f"{name}.py").is_file():
                yield f"to import it, add --allow {quoted(folder)}"
                return

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        """Return the stub module that records calls, or a new stub module."""
        return self.modules.get(spec.name) or StubModule(_known(spec.name), self.recorder, self.modules)

    def exec_module(self, module: types.ModuleType) -> None:
        """Do nothing, because `create_module` returns a complete module."""


def _known(name: str) -> str:
    """Return a module name as in the script, without the prefix from `PACKAGE` that relative imports add."""
    return name.rpartition(f"{_ABOVE}.")[2]
