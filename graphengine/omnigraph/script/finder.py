"""What a script finds when it imports: modules of Python, modules beside it, and stand-ins for everything else."""

from __future__ import annotations

import importlib.abc
import importlib.util
import os
import types
from collections.abc import Mapping, Sequence
from importlib.machinery import ModuleSpec, PathFinder
from typing import Any

from graphengine.omnigraph.omniverse.modules import ROOTS
from graphengine.omnigraph.omniverse.recorder import Recorder
from graphengine.omnigraph.omniverse.stand_in import StandInModule

OFFERED = (
    "abc argparse ast base64 bisect collections collections.abc contextlib copy csv dataclasses datetime decimal "
    "enum errno fractions functools glob hashlib heapq importlib importlib.util inspect io itertools json logging "
    "math numbers operator os os.path pathlib platform pprint pwd random re shutil signal statistics string "
    "struct sys tempfile textwrap threading time traceback types typing typing_extensions uuid warnings weakref "
    "yaml"
)
"""Modules that a script gets as they are; of others that do not lie beside it there are stand-ins."""

_ABOVE = "above"
PACKAGE = f"{_ABOVE}.{_ABOVE}.{_ABOVE}.{_ABOVE}.beside"
"""The package that a script is in, for its relative imports; those above it are stand-ins."""


class Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds the modules that a script imports.

    Args:
        recorder: told of modules that are not imported.
        modules: what is known, by name.
        folder: that the script is in.
    """

    def __init__(self, recorder: Recorder, modules: Mapping[str, Any], folder: str) -> None:
        self.recorder, self.modules, self.folder = recorder, modules, folder

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: types.ModuleType | None = None
    ) -> ModuleSpec | None:
        """What is known, what lies beside the script, else a stand-in."""
        if name == PACKAGE:
            return self._package()
        if name not in self.modules and name.partition(".")[0] not in ROOTS:
            beside = PathFinder.find_spec(name, [self.folder] if path is None else list(path))
            if beside is not None and beside.loader is not None:
                return beside
            known = _known(name)
            if "." not in known and not PACKAGE.startswith(name):
                self.recorder.findings.add("N302", f"module {known!r} is not imported", self.recorder.where(known))
        return ModuleSpec(name, self, is_package=True)

    def _package(self) -> ModuleSpec:
        """The script's own package, whose `__init__.py` is run if there is one."""
        start = os.path.join(self.folder, "__init__.py")
        if os.path.isfile(start):
            found = importlib.util.spec_from_file_location(PACKAGE, start, submodule_search_locations=[self.folder])
            if found is not None:
                return found
        spec = ModuleSpec(PACKAGE, self, is_package=True)
        spec.submodule_search_locations = [self.folder]
        return spec

    def create_module(self, spec: ModuleSpec) -> types.ModuleType:
        """The one that stands for it."""
        return self.modules.get(spec.name) or StandInModule(_known(spec.name), self.recorder, self.modules)

    def exec_module(self, module: types.ModuleType) -> None:
        """Nothing: it is complete."""


def _known(name: str) -> str:
    """The name of a module as its script has it."""
    return name.rpartition(f"{_ABOVE}.")[2]
