"""Finds transports by name: built-in transports in the folders beside this file, other transports by entry points."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import replace
from functools import cache
from importlib.metadata import EntryPoint, entry_points

from graphengine.format.entry_points import by_name, first_line, load_only, package_of
from graphengine.format.errors import GraphError, TransportError
from graphengine.format.wording import did_you_mean, listing
from graphengine.ros import transports
from graphengine.ros.transport import JoinOptions, Transport, TransportKind

GROUP = "graphengine.transports"
AUTO = "auto"


def transport_helps(*, reaching_others: bool = False) -> dict[str, str]:
    """Return the help line of each transport, by name; with `reaching_others`, only transports that leave the process."""
    kinds, broken = _load_all()
    ranked = ", ".join(kind.name for kind in kinds if kind.auto is not None)
    shown = {kind.name: kind.help for kind in kinds if kind.reaches_others or not reaching_others}
    return {AUTO: f"the first of {ranked} that can be used", **shown, **broken}


def transport_states() -> dict[str, str]:
    """Return the state of each transport, by name: `can be used`, or the reason why not and further lines with remedies."""
    kinds, broken = _load_all()
    return {kind.name: _missing(kind) or "can be used" for kind in kinds} | broken


def find_transport(name: str) -> TransportKind:
    """Return the transport with this name; the function does not check whether the transport can be used on this machine.

    Raises:
        TransportError: no or several packages provide a transport with this name, or its package cannot be imported.
    """
    known = _entries()
    if name not in known:
        hint = did_you_mean(name, known) or listing(known, "transports")
        raise TransportError(f"no transport {name!r}\n{hint}")
    return _load(name, known[name])


def open_transport(name: str, options: JoinOptions) -> Transport:
    """Join a domain and return the transport, whose description says why `auto` chose this transport.

    Args:
        name: name of the transport; `auto` chooses the first usable transport: rclpy if ROS 2 is sourced, else dds.
        options: domain and name of the node.

    Raises:
        TopicError: the node's name or namespace is not legal in ROS 2.
        TransportError: `find_transport` fails, the transport cannot be used on this machine, or it cannot join the domain.
    """
    if name != AUTO:
        kind = find_transport(name)
        if (missing := _missing(kind)) is not None:
            raise TransportError(f"{name} cannot be used: {missing}")
        return _open(kind, options)
    kinds, broken = _load_all()
    reasons, remedies = list(broken.values()), list[str]()
    for kind in kinds:
        if kind.auto is None:
            continue
        if (missing := _missing(kind)) is not None:
            why, *further = missing.splitlines()
            reasons.append(f"{kind.name} cannot be used ({why})")
            remedies += further
        elif (left_out := kind.not_for_auto()) is not None:
            reasons.append(f"{kind.name} is left out ({left_out})")
        else:
            because = f"chosen because {' and '.join(reasons) or f'{kind.name} is installed'}"
            try:
                return _open(kind, replace(options, because=because))
            except TransportError as error:
                if not isinstance(error.__cause__, ImportError):
                    raise
                reasons.append(f"{kind.name} cannot be imported ({first_line(error.__cause__)})")
    raise TransportError("\n".join([f"no transport can be used: {'; '.join(reasons)}", *remedies]))


def _open(kind: TransportKind, options: JoinOptions) -> Transport:
    try:
        return kind.open(options)
    except GraphError:
        raise
    except Exception as error:  # a package may fail in any way
        what = f"transport {kind.name!r} cannot join domain {options.domain.id}"
        raise TransportError(f"{what}: {first_line(error)}") from error


def _missing(kind: TransportKind) -> str | None:
    """Return the reason why a transport cannot be used, or the error of the transport's check; None if it can be used."""
    try:
        return kind.missing()
    except Exception as error:  # a package may fail in any way
        return first_line(error)


def _load(name: str, entries: list[EntryPoint]) -> TransportKind:
    """Return the transport with this name from the only entry point; the errors are those of `find_transport`."""
    try:
        kind = load_only("transport", entries, ", or use another --transport")
    except GraphError as error:
        raise TransportError(str(error)) from error
    if not isinstance(kind, TransportKind) or kind.name != name:
        (entry,) = entries
        raise TransportError(f"{entry.value} of {package_of(entry)} is not a TransportKind with the name {name!r}")
    return kind


def _load_all() -> tuple[list[TransportKind], dict[str, str]]:
    """Return all transports, sorted by rank for `auto`, and the error text of each transport that fails to load, by name."""
    kinds, broken = [], {}
    for name, entries in _entries().items():
        try:
            kinds.append(_load(name, entries))
        except TransportError as error:
            broken[name] = str(error).splitlines()[0]
    return sorted(kinds, key=lambda kind: (kind.auto is None, kind.auto, kind.name)), broken


@cache
def _entries() -> dict[str, list[EntryPoint]]:
    """Return the entry points of each transport name; built-in transports are found even if graphengine is not installed.

    The result is cached, because the search reads a file of each installed package.
    """
    modules = pkgutil.iter_modules(transports.__path__, "graphengine.ros.transports.")
    folders = [module.name for module in modules if module.ispkg]
    own = [EntryPoint(importlib.import_module(name).TRANSPORT.name, f"{name}:TRANSPORT", GROUP) for name in folders]
    return by_name((*entry_points(group=GROUP), *own))
