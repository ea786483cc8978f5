"""Registries filled by the modules of a package: to add a kind, add a module."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Kinds(Generic[T]):
    """A registry of entries by kind, which the modules of a package add when they are imported.

    Args:
        package: full name of the package; its modules are imported at the first call of `all`.
    """

    def __init__(self, package: str) -> None:
        self._package = package
        self._entries: dict[str, tuple[int, T]] = {}

    def add(self, kind: str, entry: T, rank: int = 0) -> None:
        """Register the entry of a kind; entries with a lower rank are listed first.

        Raises:
            ValueError: the kind already has an entry.
        """
        if kind in self._entries:
            raise ValueError(f"two modules of {self._package} define {kind!r}")
        self._entries[kind] = (rank, entry)

    @cached_property
    def all(self) -> Mapping[str, T]:
        """All entries, sorted by rank and kind."""
        package = importlib.import_module(self._package)
        for module in pkgutil.iter_modules(package.__path__, f"{self._package}."):
            if not module.ispkg:
                importlib.import_module(module.name)
        ranked = sorted(self._entries, key=lambda kind: (self._entries[kind][0], kind))
        return MappingProxyType({kind: self._entries[kind][1] for kind in ranked})


DEVICES: Kinds[Any] = Kinds("graphengine.devices")
"""The kinds of device that robot files can mount; entries are `Device` objects of `graphengine.devices.device`."""
