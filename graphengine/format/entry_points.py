"""Loads the objects that installed packages register as entry points, such as transports and verbs of `graphrun`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from importlib.metadata import EntryPoint
from typing import Any

from graphengine.format.errors import GraphError


def by_name(entries: Iterable[EntryPoint]) -> dict[str, list[EntryPoint]]:
    """Return the entry points with each name, sorted by name; there are several if several packages use the same name."""
    found: dict[str, list[EntryPoint]] = {}
    for entry in dict.fromkeys(entries):  # some environments list a package twice
        found.setdefault(entry.name, []).append(entry)
    return dict(sorted(found.items()))


def load_only(kind: str, entries: Sequence[EntryPoint], otherwise: str = "") -> Any:
    """Import the object of the only entry point with a name.

    Args:
        kind: noun for the object in messages, such as `transport`.
        entries: all entry points with this name.
        otherwise: another remedy for a package that cannot be imported, such as `, or use another --transport`.

    Raises:
        GraphError: there are several entry points, or the package cannot be imported.
    """
    entry = entries[0]
    if len(entries) > 1:
        values = ", ".join(sorted(entry.value for entry in entries))
        raise GraphError(f"several packages provide a {kind} {entry.name!r}: {values}\nuninstall all but one")
    try:
        return entry.load()
    except (Exception, SystemExit) as error:  # a package may fail in any way
        package = package_of(entry)
        what = f"{kind} {entry.name!r} of {package} cannot be imported: {first_line(error)}"
        raise GraphError(f"{what}\ninstall the dependencies of {package}, or uninstall it{otherwise}") from error


def package_of(entry: EntryPoint) -> str:
    """Return the name of the package that has an entry point."""
    return entry.dist.name if entry.dist else entry.value


def first_line(error: BaseException) -> str:
    """Return the type of an error and the first line of its text."""
    return f"{type(error).__name__}: {error}".splitlines()[0]
