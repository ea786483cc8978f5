"""Finds node types by registered name, by short name, or by their name before Isaac Sim 4.5.

Graph files cannot import Python modules: types come from the package `graphengine.nodes`, from entry points of the group
`graphengine.nodes`, and from modules that the user imports with `--import`.
"""

from __future__ import annotations

import functools
import importlib
import importlib.metadata
import json
import pkgutil
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError
from graphengine.format.wording import did_you_mean
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.node.node_class import Node

GROUP = "graphengine.nodes"
INDEX = "index.json"
"""Name of the file in the folder of `graphengine.nodes` that lists the node types of each module; a test generates it."""

OLD_PREFIXES: dict[str, tuple[str, ...]] = {
    "omni.isaac.core_nodes.": ("isaacsim.core.nodes.",),
    "omni.isaac.ros2_bridge.": ("isaacsim.ros2.bridge.",),
    "omni.isaac.wheeled_robots.": ("isaacsim.robot.wheeled_robots.",),
    "omni.isaac.sensor.": ("isaacsim.sensors.physics.", "isaacsim.sensors.rtx."),
    "omni.isaac.range_sensor.": ("isaacsim.sensors.physx.",),
    "omni.isaac.conveyor.": ("isaacsim.asset.gen.conveyor.",),
    "omni.isaac.manipulators.": ("isaacsim.robot.manipulators.",),
    "omni.isaac.surface_gripper.": ("isaacsim.robot.surface_gripper.",),
}
"""Prefixes of registered names before Isaac Sim 4.5, each with the prefixes that replaced it."""

_SHORT_PREFIXES = ("Ogn", "Isaac", "ROS2")


@dataclass(frozen=True, slots=True)
class Found:
    """The result of `Registry.find`: a node type, and whether it was found by a name from before Isaac Sim 4.5."""

    cls: type[Node]
    old_name: bool = False


@dataclass(slots=True)
class Registry:
    """All node types that a graph file can use, by registered name and short name."""

    imported: dict[str, type[Node]] = field(default_factory=dict)
    """Node types whose modules were imported, by name and alias."""
    short_names: dict[str, str] = field(default_factory=dict)
    owners: dict[str, str] = field(default_factory=dict)
    """Name of the distribution or module that provides each type, by name and alias of the type."""
    broken: dict[str, str] = field(default_factory=dict)
    """Error message for each plugin that could not be imported, by name of the plugin."""
    definitions: Definitions = DEFINITIONS
    """Definitions of message types; the fields of a message become ports of some node types."""
    modules: dict[str, str] = field(default_factory=dict)
    """Name of the module of each type whose module is imported only when the type is used."""

    @property
    def types(self) -> dict[str, type[Node]]:
        """All node types, by name and alias; imports their modules."""
        return {name: self._import(name) for name in self.owners}

    def copy(self, definitions: Definitions | None = None) -> Registry:
        """Return a copy with the same node types; `definitions` replaces the message types of the copy."""
        mine = dict(self.imported), dict(self.short_names), dict(self.owners), dict(self.broken)
        return Registry(*mine, definitions or self.definitions, self.modules)

    def find(self, name: str) -> Found | None:
        """Return the node type with a registered, short or old name; None if there is no such type."""
        known = self.short_names.get(name, name)
        if known in self.owners:
            return Found(self._import(known))
        for old, news in OLD_PREFIXES.items():
            if name.startswith(old):
                last = name.removeprefix(old)
                for new in news:
                    for spelling in (last, last.removeprefix("Ogn"), f"Ogn{last}"):
                        if new + spelling in self.owners:
                            return Found(self._import(new + spelling), old_name=True)
        return None

    def suggest(self, name: str, findings: Findings | None = None) -> str:
        """Return help for an unknown type name: similar names, or how to find or import it, and plugins that failed to import.

        With `findings`, the number of searches for similar names is limited as in `Findings.guess`.
        """
        guess = findings.guess if findings else did_you_mean
        module = name.rpartition(".")[0]
        own = f"; if it is yours, add `--import {module}`" if module else ""
        near = guess(name, [*self.short_names, *self.owners]) or f"`graphrun nodes` lists every type{own}"
        missing = [f"{plugin} could not be imported ({problem})" for plugin, problem in self.broken.items()]
        return "; ".join([near, *missing])

    def _import(self, name: str) -> type[Node]:
        if name not in self.imported:
            for cls in _classes(importlib.import_module(self.modules[name])):
                self.imported |= dict.fromkeys((cls.type_name, *cls.aliases), cls)
        return self.imported[name]

    def add_module(self, module: ModuleType, owner: str, *, built_in: bool = False) -> None:
        """Register every node class that a module defines; for a package, also those of its submodules, which are imported.

        Args:
            module: the module or package.
            owner: name of the distribution or module that provides the types, for messages.
            built_in: whether short names are registered too.

        Raises:
            GraphError: a name is already taken by another class.
        """
        inner = pkgutil.walk_packages(getattr(module, "__path__", []), module.__name__ + ".")
        names = sorted(info.name for info in inner)
        classes = [cls for member in [module, *map(importlib.import_module, names)] for cls in _classes(member)]
        for cls in classes:
            self._refuse_clash(cls, owner)
        for cls in classes:
            self.add(cls, owner, built_in=built_in)

    def add(self, cls: type[Node], owner: str = "", *, built_in: bool = False) -> None:
        """Register one node class under its name and aliases; if it is built in, also under its short names.

        Raises:
            GraphError: a name is already taken by another class.
        """
        self._refuse_clash(cls, owner)
        for name in (cls.type_name, *cls.aliases):
            self.imported[name] = cls
            self.owners[name] = owner
        if built_in:
            self._shorten(cls.type_name)

    def add_library(self, package: ModuleType, owner: str) -> None:
        """Register the node types that the file `INDEX` of a package lists, under full and short names.

        Their modules are not imported.
        """
        index = json.loads((Path(package.__path__[0]) / INDEX).read_text("utf-8"))
        for module, names in index.items():
            for name in names:
                self.modules[name] = f"{package.__name__}.{module}"
                self.owners[name] = owner
                self._shorten(name)

    def _shorten(self, name: str) -> None:
        for short in short_names(name):
            self.short_names.setdefault(short, name)

    def _refuse_clash(self, cls: type[Node], owner: str) -> None:
        for name in (cls.type_name, *cls.aliases):
            taken = self.short_names.get(name, name)
            other = self._import(taken) if taken in self.owners else cls
            if other is not cls:
                raise GraphError(
                    f"two node types are called {name!r}: {other.__module__}.{other.__qualname__} of "
                    f"{self.owners[taken]}, and {cls.__module__}.{cls.__qualname__} of {owner}"
                )


def short_names(type_name: str) -> list[str]:
    """Return the short names of a type: the last part of its name, with and without the prefixes `Ogn`, `Isaac` and `ROS2`."""
    last = type_name.rpartition(".")[2]
    names = [last]
    for prefix in _SHORT_PREFIXES:
        names += [name.removeprefix(prefix) for name in list(names) if name.startswith(prefix)]
    return list(dict.fromkeys(names))


def _classes(module: ModuleType) -> list[type[Node]]:
    """Return the node types that a module defines, without imported node types."""
    classes = [value for value in vars(module).values() if isinstance(value, type) and issubclass(value, Node)]
    return list(dict.fromkeys(cls for cls in classes if cls.type_name and cls.__module__ == module.__name__))


@functools.cache
def default_registry() -> Registry:
    """Return the registry of the node types of graphengine and of installed plugins, always the same object.

    `broken` lists the plugins that cannot be imported.
    """
    registry = Registry()
    registry.add_library(importlib.import_module("graphengine.nodes"), "graphengine")
    for entry in sorted(importlib.metadata.entry_points(group=GROUP), key=lambda e: (e.name, e.value)):
        if entry.value == "graphengine.nodes":
            continue
        owner = entry.dist.name if entry.dist else entry.name
        try:
            registry.add_module(entry.load(), owner)
        except (Exception, SystemExit) as error:  # a plugin may fail in any way; its types are then unavailable
            registry.broken[f"{owner}: {entry.value}"] = f"{type(error).__name__}: {error}"
    return registry
