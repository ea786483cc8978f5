"""A registry to which the modules of a package add entries, so that a new kind of device, for example, is only a new module."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Kinds(Generic[T]):
    """A registry of entries by kind; the modules of a package add the entries when they are imported.

    Args:
        package: full name of the package; the first use of `all` imports its modules.
    """

    def __init__(self, package: str) -> None:
        self._package = package
        self._entries: dict[str, tuple[int, T]] = {}

    def add(self, kind: str, entry: T, rank: int = 0) -> None:
        """Register the entry of a kind; `all` lists entries with a lower rank first.

        Raises:
            ValueError: the kind already has an entry.
        """
        if kind in self._entries:
            raise ValueError(f"two modules of {self._package} define {kind!r}")
        self._entries[kind] = (rank, entry)

    @cached_property
    def all(self) -> Mapping[str, T]:
        """All entries by kind, sorted by rank and then by kind; imports the modules of the package."""
        package = importlib.import_module(self._package)
        for module in pkgutil.iter_modules(package.__path__, f"{self._package}."):
            if not module.ispkg:
                importlib.import_module(module.name)
        ranked = sorted(self._entries, key=lambda kind: (self._entries[kind][0], kind))
        return MappingProxyType({kind: self._entries[kind][1] for kind in ranked})


DEVICES: Kinds[Any] = Kinds("graphengine.devices")
"""The kinds of sensors for `sensors` of a robot file; the entries are `graphengine.devices.device.Device` objects."""
