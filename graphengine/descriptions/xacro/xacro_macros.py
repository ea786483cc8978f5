"""Finds xacro macros that define robots, and generates xacro files that call a macro."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element, write
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.ros_packages import MANIFEST, manifest_name
from graphengine.format.wording import did_you_mean, listing, printable, quoted

PREFIX = "xacro:"
MAX_PARAMETERS = 10_000
"""Maximum number of characters read from the `params` attribute of a macro."""
_NO_CALLS = ("include", "property", "macro", "arg", "if", "unless", "insert_block", "element", "attribute")
_PARAMETER = re.compile(r"""([^\s:=]+)(?:\s*:?=\s*((?:'[^']*'|"[^"]*"|[^\s'"])*))?""")
"""Matches the name of a macro parameter and its default, as in `name`, `name:=value` and `name:=^|'a value'`."""
_NAME = re.compile(r"[A-Za-z_][\w.:-]*")
_BLOCK = "*"
"""Prefix of the name of a block parameter; the value of a block parameter is an element inside the call."""


@dataclass(frozen=True, slots=True)
class RobotMacro:
    """A macro that creates links.

    Attributes:
        name: name of the macro.
        parameters: defaults by name, as written in the file; None for a parameter without a default.
        blocks: names of the block parameters (elements inside a call), in order.
        span: source location of the definition.
    """

    name: str
    parameters: dict[str, str | None]
    blocks: list[str]
    span: Span


def robot_macros(root: Element) -> list[RobotMacro]:
    """Return the macros of a file that contain links, in order of the file."""
    macros = (element for element in root.walk() if element.tag == f"{PREFIX}macro")
    return [
        _macro(element)
        for element in macros
        if _NAME.fullmatch(element.get("name")) and any(part.tag == "link" for part in element.walk())
    ]


def _macro(element: Element) -> RobotMacro:
    found = _PARAMETER.findall(element.get("params")[:MAX_PARAMETERS])
    values = {name: default or None for name, default in found if not name.startswith(_BLOCK)}
    blocks = [name.lstrip(_BLOCK) for name, _ in found if name.startswith(_BLOCK)]
    blocks = [name if _NAME.fullmatch(name) else "block" for name in blocks]
    return RobotMacro(element.get("name").removeprefix(PREFIX), values, blocks, element.span)


def has_robot(root: Element) -> bool:
    """Return whether a file creates a robot itself: it has a link or a macro call outside of macro definitions."""
    calls = (part.tag.removeprefix(PREFIX) for part in _outside_macros(root) if part.tag.startswith(PREFIX))
    return any(part.tag == "link" for part in _outside_macros(root)) or any(call not in _NO_CALLS for call in calls)


def _outside_macros(root: Element) -> Iterator[Element]:
    pending = [root]
    while pending:
        element = pending.pop()
        yield element
        pending.extend(child for child in element.children if child.tag != f"{PREFIX}macro")


def choose_macro(
    root: Element, wanted: str | None, arguments: Collection[str], findings: Findings
) -> RobotMacro | None:
    """Return the macro that defines the robot; None if the file creates the robot itself, or if no macro can be chosen.

    Args:
        root: root element of the file.
        wanted: name of the macro. By default, the only macro with links is used if the file does not create a robot itself.
        arguments: names of the arguments that have a value.
        findings: receives an error if several macros qualify, no macro has the wanted name, or a parameter lacks a value.
    """
    macro = _chosen(root, wanted, findings)
    needed = [key for key, value in macro.parameters.items() if value is None] if macro is not None else []
    if macro is not None and (missing := [name for name in needed if name not in arguments]):
        text = f"the macro {macro.name!r} needs a value of {', '.join(map(repr, missing))}"
        values = " ".join(f"{printable(name)}:=…" for name in missing)
        findings.add("S103", text, macro.span, f"add to the command: {values}")
    return macro


def _chosen(root: Element, wanted: str | None, findings: Findings) -> RobotMacro | None:
    macros = {macro.name: macro for macro in robot_macros(root)}
    if wanted is None and (len(macros) == 1 or has_robot(root)):
        return next(iter(macros.values())) if macros and not has_robot(root) else None
    if wanted is None and macros:
        names = ", ".join(f"--macro {quoted(name)}" for name in macros)
        findings.add("S103", "the file defines several robot macros and calls none", root.span, f"choose: {names}")
    elif wanted is not None and wanted not in macros:
        near = did_you_mean(wanted, macros) or listing(macros, "macros with links")
        findings.add("S103", f"the file defines no macro {wanted!r} that contains links", root.span, near)
    return macros.get(wanted) if wanted is not None else None


def wrapper(
    macro: RobotMacro, path: Path, name: str, arguments: Mapping[str, str], packages: Packages, *, complete: bool
) -> str:
    """Return the text of a xacro file that includes the file in which a macro is defined, and calls the macro.

    Args:
        macro: macro to call.
        path: path of the file that defines the macro.
        name: name of the robot.
        arguments: values of the macro's parameters and of the file's arguments, by name.
        packages: known ROS packages; if one of them contains `path`, the include refers to this package.
        complete: whether values of the file's arguments are written in addition to values of the macro's parameters.
    """
    others = {key: value for key, value in arguments.items() if key not in macro.parameters} if complete else {}
    given = {key: value for key, value in arguments.items() if key in macro.parameters}
    defaults = [f"{key}:={value}" for key, value in macro.parameters.items() if value is not None and key not in given]
    lines = ['<?xml version="1.0"?>', f"<!-- Makes a robot of the macro {_comment(macro.name)}. "]
    lines[-1] += "After a change, import this file again. -->"
    lines += [write(Element("robot", {"name": name, "xmlns:xacro": "http://www.ros.org/wiki/xacro"}, macro.span))[0]]
    lines[-1] = lines[-1].removesuffix("/>") + ">"
    lines += [f"  {_tag('arg', {'name': key, 'default': literal(value)}, macro)}" for key, value in others.items()]
    lines += [f"  {_tag('include', {'filename': _reference(path, packages)}, macro)}"]
    if defaults:
        lines += [f"  <!-- defaults: {_comment(' '.join(defaults))} -->"]
    call = _tag(macro.name, {key: literal(value) for key, value in given.items()}, macro)
    if macro.blocks:
        inside = [f"    <{block}{_ORIGIN if block == 'origin' else ''}/>" for block in macro.blocks]
        lines += [f"  {call.removesuffix('/>')}>", *inside, f"  </{PREFIX}{macro.name}>"]
    else:
        lines += [f"  {call}"]
    return "\n".join([*lines, "</robot>", ""])


_ORIGIN = ' xyz="0 0 0" rpy="0 0 0"'


def _tag(name: str, attributes: dict[str, str], macro: RobotMacro) -> str:
    return write(Element(f"{PREFIX}{name}", attributes, macro.span))[0]


def literal(value: str) -> str:
    """Return the text with `$(` and `${` escaped; xacro expands the result to the text."""
    return value.replace("$(", "$$(").replace("${", "$${")


def _comment(text: str) -> str:
    """Return the text in a form that is legal in an XML comment, which must not contain `--`."""
    return printable(re.sub("-(?=-)", "- ", text)).rstrip("-")


def _reference(path: Path, packages: Packages) -> str:
    """Return a reference to a file for xacro: `$(find PACKAGE)/…` if a package contains the file, else its absolute path."""
    resolved = path.resolve()
    for folder in resolved.parents:
        name = manifest_name(folder) if (folder / MANIFEST).is_file() else None
        if name is not None and (found := packages.find(name)) is not None and found.resolve() == folder:
            return f"$(find {name})/{resolved.relative_to(folder).as_posix()}"
    return str(resolved)
