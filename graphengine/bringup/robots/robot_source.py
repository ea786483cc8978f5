"""Reads the description to import from a URDF, xacro or SDF file, according to the user's options."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.sdf.sdf_files import is_sdf
from graphengine.descriptions.sdf.sdf_reader import read_sdf
from graphengine.descriptions.xacro import xacro
from graphengine.descriptions.xacro.absent_packages import drop_meshes, report_mesh_packages
from graphengine.descriptions.xacro.xacro_macros import choose_macro, robot_macros, wrapper
from graphengine.format.diagnostics import Findings
from graphengine.format.wording import quoted

WRAPPER = ".urdf.xacro"
"""Suffix of the generated xacro file that calls a macro as the robot."""


@dataclass(frozen=True, slots=True)
class Wishes:
    """The user's options for reading a description.

    Attributes:
        arguments: a dict from xacro arguments and macro parameters to their values.
        macro: name of the macro that defines the robot; None if the user names none.
        without: names of packages to leave out.
        model: name of the robot's model in an SDF file; empty if the user names none.
    """

    arguments: Mapping[str, str] = field(default_factory=dict)
    macro: str | None = None
    without: Collection[str] = ()
    model: str = ""


@dataclass(frozen=True, slots=True)
class RobotSource:
    """A description after xacro expansion.

    Attributes:
        element: root element of the description as URDF.
        as_given: whether the file contains this description without expansion, conversion or omission.
        wrapper: text of the generated xacro file that calls the macro; empty without a macro.
    """

    element: Element
    as_given: bool = False
    wrapper: str = ""


def read_source(
    path: Path, root: Element, target: Path, wishes: Wishes, packages: Packages, findings: Findings
) -> RobotSource | None:
    """Return a description as URDF, with xacro expanded and SDF converted; None after an error.

    Args:
        path: path of the description's file.
        root: root element of that file.
        target: path of the robot file to write.
        wishes: the user's options.
        packages: packages to which the description may refer.
        findings: receives errors, and notes on choices and omissions.
    """
    before = len(findings.errors)
    if is_sdf(root):
        whole: Element | None = root
        if xacro.is_xacro(path, root):
            whole = xacro.expand(path, wishes.arguments, packages, findings, without=wishes.without)
        model = read_sdf(path, whole, packages, findings, wishes.model) if whole is not None else None
        return _checked(RobotSource(model.element), wishes, packages, findings, before) if model is not None else None
    if not xacro.is_xacro(path, root):
        return _checked(RobotSource(root, as_given=not wishes.without), wishes, packages, findings, before)
    macro = choose_macro(root, wishes.macro, wishes.arguments, findings)
    if macro is not None and target.with_suffix(WRAPPER).resolve() == path.resolve():
        text = f"the file that calls the macro {macro.name!r} would overwrite {str(path)!r}"
        findings.add("S103", text, macro.span, "choose another name for the robot file")
    if len(findings.errors) > before:
        return None
    if macro is None:
        element = xacro.expand(path, wishes.arguments, packages, findings, without=wishes.without)
        text = ""
    else:
        file = target.with_suffix(WRAPPER)
        trial, text = (
            wrapper(macro, path, target.stem, wishes.arguments, packages, complete=complete)
            for complete in (False, True)
        )
        others = {key: value for key, value in wishes.arguments.items() if key not in macro.parameters}
        element = xacro.expand(file, others, packages, findings, text=trial, without=wishes.without)
        if wishes.macro is None:
            told = f"the file defines macros but no robot; {file.name} calls its macro {macro.name!r}"
            findings.add("N103", told, macro.span)
    source = RobotSource(element, wrapper=text) if element is not None else None
    return _checked(source, wishes, packages, findings, before) if source is not None else None


def _checked(
    source: RobotSource, wishes: Wishes, packages: Packages, findings: Findings, before: int
) -> RobotSource | None:
    """Return the source without meshes of packages to leave out; None after an error, such as a missing package of a mesh."""
    drop_meshes(source.element, wishes.without, findings)
    report_mesh_packages(source.element, packages, findings)
    return source if len(findings.errors) == before else None


def arguments_of(path: Path, root: Element, packages: Packages, findings: Findings) -> list[str]:
    """Return lines of text that list the arguments of a xacro file and the parameters of its robot macros, with defaults."""
    if not xacro.is_xacro(path, root):
        return [f"{path}: no xacro syntax, so it takes no arguments"]
    lines = [f"arguments of {path}:", *_listed(xacro.defaults(path, packages, findings))]
    for macro in robot_macros(root):
        lines += [f"parameters of the macro {macro.name}, which --macro {quoted(macro.name)} imports as a robot:"]
        lines += _listed(macro.parameters)
    return lines


def _listed(defaults: Mapping[str, str | None]) -> list[str]:
    width = max(map(len, defaults), default=0)
    values = {name: "no default" if value is None else f"default {value!r}" for name, value in defaults.items()}
    return [f"  {name:{width}}  {value}" for name, value in values.items()] or ["  none"]
