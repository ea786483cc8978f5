"""Node types by name: registered names, short names of built-ins, names from before Isaac Sim 4.5; and lints.

A YAML file never names Python code: types come from `graphengine.nodes`, from entry points of the group `graphengine.nodes`,
and from modules that the user imports on the command line.
"""

from __future__ import annotations

import functools
import importlib
import importlib.metadata
import pkgutil
from collections.abc import Iterable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError
from graphengine.format.wording import did_you_mean
from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.node.node_class import Node

GROUP = "graphengine.nodes"

OLD_PREFIXES: dict[str, tuple[str, ...]] = {
    "omni.isaac.core_nodes.": ("isaacsim.core.nodes.",),
    "omni.isaac.ros2_bridge.": ("isaacsim.ros2.bridge.",),
    "omni.isaac.wheeled_robots.": ("isaacsim.robot.wheeled_robots.",),
    "omni.isaac.sensor.": ("isaacsim.sensors.physics.", "isaacsim.sensors.rtx."),
    "omni.isaac.range_sensor.": ("isaacsim.sensors.physx.",),
}
"""Prefixes of registered names before Isaac Sim 4.5, and where those types went."""

_SHORT_PREFIXES = ("Ogn", "Isaac", "ROS2")


@dataclass(frozen=True, slots=True)
class Found:
    """A node type, and the current name if an old one was used."""

    cls: type[Node]
    old_name: bool = False


@dataclass(slots=True)
class Registry:
    """All node types that a file can name."""

    types: dict[str, type[Node]] = field(default_factory=dict)
    short_names: dict[str, str] = field(default_factory=dict)
    owners: dict[str, str] = field(default_factory=dict)
    """Distribution or module that brought each type."""
    broken: dict[str, str] = field(default_factory=dict)
    """Plugins that could not be imported, and why."""
    definitions: Definitions = DEFINITIONS
    """Message types, from whose fields some node types grow ports."""

    def copy(self, definitions: Definitions | None = None) -> Registry:
        """The same types, to which others can be added without this one being changed; and other message types."""
        mine = dict(self.types), dict(self.short_names), dict(self.owners), dict(self.broken)
        return Registry(*mine, definitions or self.definitions)

    def find(self, name: str) -> Found | None:
        """The type that a name means, or None."""
        if name in self.types:
            return Found(self.types[name])
        if name in self.short_names:
            return Found(self.types[self.short_names[name]])
        for old, news in OLD_PREFIXES.items():
            if name.startswith(old):
                last = name.removeprefix(old)
                for new in news:
                    for spelling in (last, last.removeprefix("Ogn"), f"Ogn{last}"):
                        if new + spelling in self.types:
                            return Found(self.types[new + spelling], old_name=True)
        return None

    def suggest(self, name: str, findings: Findings | None = None) -> str:
        """Names near to one that is unknown, or where the legal ones are listed, and which plugins are missing."""
        guess = findings.guess if findings else did_you_mean
        near = guess(name, [*self.short_names, *self.types]) or "`graphrun nodes` lists every type"
        missing = [f"{plugin} could not be imported ({problem})" for plugin, problem in self.broken.items()]
        return "; ".join([near, *missing])

    def add_module(self, module: ModuleType, owner: str, *, built_in: bool = False) -> None:
        """Register every node class of a module, and of its submodules if it is a package.

        Raises:
            GraphError: two classes want one name.
        """
        names = sorted(
            info.name for info in pkgutil.walk_packages(getattr(module, "__path__", []), module.__name__ + ".")
        )
        modules = [module, *map(importlib.import_module, names)]
        classes = [cls for member in modules for cls in _classes(vars(member).values(), member.__name__)]
        for cls in classes:
            self._refuse_clash(cls, owner)
        for cls in classes:
            self.add(cls, owner, built_in=built_in)

    def add(self, cls: type[Node], owner: str = "", *, built_in: bool = False) -> None:
        """Register one node class under its name, its aliases and, for a built-in, its short names.

        Raises:
            GraphError: another class has the name.
        """
        self._refuse_clash(cls, owner)
        for name in (cls.type_name, *cls.aliases):
            self.types[name] = cls
            self.owners[name] = owner
        if built_in:
            for short in short_names(cls.type_name):
                self.short_names.setdefault(short, cls.type_name)

    def _refuse_clash(self, cls: type[Node], owner: str) -> None:
        for name in (cls.type_name, *cls.aliases):
            taken = self.short_names.get(name, name)
            other = self.types.get(taken, cls)
            if other is not cls:
                raise GraphError(
                    f"two node types are called {name!r}: {other.__module__}.{other.__qualname__} of "
                    f"{self.owners[taken]}, and {cls.__module__}.{cls.__qualname__} of {owner}"
                )


def short_names(type_name: str) -> list[str]:
    """The last part of a registered name, and the same without `Ogn`, `Isaac` and `ROS2` in front."""
    last = type_name.rpartition(".")[2]
    names = [last]
    for prefix in _SHORT_PREFIXES:
        names += [name.removeprefix(prefix) for name in list(names) if name.startswith(prefix)]
    return list(dict.fromkeys(names))


def _classes(values: Iterable[Any], module: str) -> list[type[Node]]:
    found = [
        v for v in values if isinstance(v, type) and issubclass(v, Node) and v.type_name and v.__module__ == module
    ]
    return list(dict.fromkeys(found))


@functools.cache
def default_registry() -> Registry:
    """Built-in types and those of installed plugins; a plugin that cannot be imported is remembered, not fatal."""
    registry = Registry()
    registry.add_module(importlib.import_module("graphengine.nodes"), "graphengine", built_in=True)
    for entry in sorted(importlib.metadata.entry_points(group=GROUP), key=lambda e: (e.name, e.value)):
        if entry.value == "graphengine.nodes":
            continue
        owner = entry.dist.name if entry.dist else entry.name
        try:
            registry.add_module(entry.load(), owner)
        except (Exception, SystemExit) as error:  # a plugin may fail in any way; its types are then simply not there
            registry.broken[f"{owner}: {entry.value}"] = f"{type(error).__name__}: {error}"
    return registry
