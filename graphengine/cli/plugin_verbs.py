"""Verbs that installed packages add to `graphrun`, by entry points of the group `graphengine.verbs`.

The name of an entry point is the verb. It refers to a module like those of the built-in verbs, with a constant `HELP`:

    HELP = "print how far a robot drives"                             one line, as in `VERBS` of `graphengine.cli`
    def add_arguments(parser: argparse.ArgumentParser) -> None        adds the arguments of the verb to its parser
    def execute(arguments: argparse.Namespace) -> int                 executes the verb and returns the exit code

A GraphError of `execute` is printed like an error of a built-in verb; another exception is printed with its traceback.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from graphengine.cli.common import clean
from graphengine.cli.parser import add_verb
from graphengine.cli.terminal import wrapped
from graphengine.format.entry_points import by_name, first_line, load_only, package_of
from graphengine.format.errors import GraphError

GROUP = "graphengine.verbs"
_PARTS: dict[str, Any] = {"HELP": str, "add_arguments": Callable, "execute": Callable}


def add_plugin_verbs(parser: argparse.ArgumentParser, verbs: Any, chosen: str, old_names: Iterable[str]) -> None:
    """Add the verbs of installed packages to the parser of `graphrun`. Built-in verbs of the same name take precedence.

    Args:
        parser: the parser.
        verbs: subparsers of the built-in verbs.
        chosen: the verb to execute. Other verbs are added without arguments, for suggestions. If the module of the verb cannot
            be used, the process ends with an error. If `chosen` is empty, all verbs are added with their arguments; the help of
            a verb that cannot be used gives the reason.
        old_names: former names of built-in verbs.
    """
    found = by_name(entry_points(group=GROUP))
    own = {*verbs.choices, *old_names}
    unused = ", ".join(f"{name} of {package_of(entry)}" for name in found if name in own for entry in found[name])
    parser.epilog = "If a package has a verb with the name of a built-in verb, graphrun uses the built-in verb"
    parser.epilog += f"; not used: {unused}." if unused else "." if found else ". No installed package has a verb."
    for name in [name for name in found if name not in own]:
        try:
            if chosen in ("", name):
                _add(verbs, name, found[name])
            else:
                verbs.add_parser(name)
        except GraphError as error:
            if chosen:
                parser.exit(1, wrapped(clean(f"error: {error}\n"), sys.stderr))
            if name not in verbs.choices:
                add_verb(verbs, name, clean(str(error).splitlines()[0]))


def _add(verbs: Any, name: str, entries: list[EntryPoint]) -> None:
    """Add one verb.

    Raises:
        GraphError: the module cannot be imported, lacks a name of `_PARTS`, or fails to add the arguments.
    """
    module = load_only("verb", entries)
    package = package_of(entries[0])
    verb, remedy = f"verb {name!r} of {package}", f"update {package}, or uninstall it"
    lacking = [part for part, kind in _PARTS.items() if not isinstance(getattr(module, part, None), kind)]
    if lacking:
        needed = "a verb needs the text HELP and the functions add_arguments(parser) and execute(arguments)"
        raise GraphError(f"{verb}: {entries[0].value} has no {' and no '.join(lacking)}\n{needed}; {remedy}")
    sub = add_verb(verbs, name, clean(f"{module.HELP} (from {package})"))
    try:
        module.add_arguments(sub)
    except Exception as error:  # a package may fail in any way
        raise GraphError(f"{verb}: add_arguments failed: {first_line(error)}\n{remedy}") from error
    sub.set_defaults(function=module.execute)
