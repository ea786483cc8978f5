"""The page of the Python API: the public names of graphengine and of its packages for users."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from graphengine.cli.node_reference import code, prose, table
from graphengine.format.stateful import Stateful

_INTRODUCTION = """# Python API

After `import graphengine as ge`, the names of the first section begin with `ge.`, as in `ge.load`. `help`, as in
`help(ge.Session)`, prints the same texts. Units are SI, and times are in simulation time, unless a text says otherwise.
"""
_MODULES = {
    "graphengine": "Scenes, sessions, robots and topics.",
    "graphengine.bringup": "Maps of scenes, localizability and calibration, after `from graphengine import bringup`.",
    "graphengine.api.gym": "Environments for Gymnasium, with the extra `gym`, as in `ge.gym.SceneEnv(scene, …)`.",
    "graphengine.node": "Classes with which you write your own node types.",
    "graphengine.testing": "Tools for tests of nodes and graphs.",
}


def pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the page."""
    rows = [(f"[{code(name)}](#{name.replace('.', '')})", about) for name, about in _MODULES.items()]
    lines = [_INTRODUCTION, *table(("module", ""), rows)]
    for module, about in _MODULES.items():
        lines += ["", f"## {module}", "", about]
        for name in public_names(module):
            lines += ["", *_of_name(name, getattr(importlib.import_module(module), name))]
    yield "python_api.md", re.sub(r"\n{3,}", "\n\n", "\n".join([*lines, ""]))


def public_names(module: str) -> list[str]:
    """Return the public names of a module, without those that say no more than a type does."""
    found = importlib.import_module(module)
    names: Iterable[str] = getattr(found, "__all__", None) or [name for name in vars(found) if not name.startswith("_")]
    shown = (
        name for name in names if inspect.isclass(getattr(found, name)) or inspect.isfunction(getattr(found, name))
    )
    return [name for name in shown if getattr(found, name).__module__.startswith("graphengine")]


def members(cls: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties of a class and of its bases in graphengine, in the order of their definition."""
    seen = set()
    for base in reversed(cls.__mro__):
        if base.__module__.startswith("graphengine") and base is not Stateful and not issubclass(cls, BaseException):
            for name, member in vars(base).items():
                if (
                    not name.startswith("_")
                    and name not in seen
                    and (callable(member) or isinstance(member, property | classmethod))
                ):
                    seen.add(name)
                    yield name, inspect.getattr_static(cls, name)


def _of_name(name: str, found: Any) -> Iterator[str]:
    yield f"### {name}"
    if inspect.isfunction(found):
        yield from ("", *_signature(name, found))
    elif issubclass(found, BaseException):
        yield from ("", f"An exception, derived from {code(found.__mro__[1].__name__)}.")
    yield from ("", *docstring(inspect.getdoc(found) or ""))
    for member, value in members(found) if inspect.isclass(found) else ():
        function = value.fget if isinstance(value, property) else getattr(value, "__func__", value)
        yield from ("", f"#### {name}.{member}", "")
        yield from [] if isinstance(value, property) or not callable(function) else [*_signature(member, function), ""]
        yield from docstring(inspect.getdoc(value) or "")


def _signature(name: str, function: Any) -> Iterator[str]:
    """Yield a call of a function with types and defaults as they stand in its source, an argument a line if it is long."""
    signature, parts, star = inspect.signature(function), list[str](), False
    for parameter in list(signature.parameters.values()):
        if parameter.name in ("self", "cls"):
            continue
        if parameter.kind is parameter.KEYWORD_ONLY and not star:
            parts.append("*")
        star = star or parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_POSITIONAL)
        kinds = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
        prefix = next((mark for kind, mark in kinds.items() if kind is parameter.kind), "")
        parts.append(prefix + parameter.name + _annotated(": ", parameter.annotation) + _default(parameter.default))
    result = _annotated(" -> ", signature.return_annotation)
    short = f"{name}({', '.join(parts)}){result}"
    lines = [short] if len(short) <= 100 else [f"{name}(", *(f"    {part}," for part in parts), f"){result}"]
    yield from ("```text", *lines, "```")


def _annotated(before: str, annotation: Any) -> str:
    if annotation is inspect.Signature.empty:
        return ""
    return before + (annotation if isinstance(annotation, str) else annotation.__name__)


def _default(value: Any) -> str:
    if value is inspect.Parameter.empty:
        return ""
    shown = "{}" if isinstance(value, Mapping) and not value else repr(value)
    return " = …" if " at 0x" in shown else f" = {shown}"


def docstring(text: str) -> Iterator[str]:
    """Yield a docstring as Markdown: its sections as lists, its examples as code."""
    section, in_example = "", False
    for line in text.splitlines():
        goes_on = in_example and line.strip()
        is_example = not section and bool(goes_on or line.startswith((">>> ", "... ", "    ")))
        if is_example != in_example:
            yield from (("", "```text") if is_example else ("```", ""))
            in_example = is_example
        if heading := re.fullmatch(r"(Args|Attributes|Returns|Raises|Yields):", line):
            section = heading[1]
            yield from (f"**{'Arguments' if section == 'Args' else section}**", "")
        elif is_example:
            yield line
        elif section and (entry := re.fullmatch(r"    (\S[^:]*): (.*)", line)) and section not in ("Returns", "Yields"):
            yield f"- {code(entry[1])}: {prose(entry[2])}"
        else:
            section = section if line.startswith("    ") or not line else ""
            yield f"  {prose(line.strip())}" if section and line.strip() else prose(line)
    if in_example:
        yield "```"
