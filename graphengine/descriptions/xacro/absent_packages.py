"""Reports the packages that a xacro file needs but that are missing, and leaves packages out on request (`--without`)."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field

from graphengine.descriptions.files.packages import Packages, package_of
from graphengine.descriptions.files.xml import Element
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing, printable, quoted

SCHEME = "package://"
"""Prefix of the text `package://NAME`, to which `$(find NAME)` expands if the package NAME is missing.

Thus a file can be expanded that only mentions the package, and includes no file of the package.
"""
MAX_NAMED = 100
"""Maximum number of missing packages, of included files of each, and of unknown macros that are reported."""


@dataclass(slots=True)
class AbsentPackage:
    """A package that is missing, or that the user leaves out with `--without`.

    Attributes:
        name: name of the package.
        span: location of its first use in the description.
        lacks: lines of a message: first the reason why the package is not found, then remedies.
        includes: files of the package that the description includes, each as `$(find NAME)/FILE`.
    """

    name: str
    span: Span | None
    lacks: list[str]
    includes: list[str] = field(default_factory=list)


@dataclass(slots=True)
class UnknownCall:
    """A call of a macro whose definition is not found, probably because an include was left out."""

    macro: str
    span: Span | None


def report(
    absent: Sequence[AbsentPackage],
    calls: Sequence[UnknownCall],
    without: Collection[str],
    findings: Findings,
    *,
    failed: bool,
) -> None:
    """Add an error for each missing package that is needed, and a note for each that was left out on request.

    Args:
        absent: missing packages.
        calls: calls of undefined macros, which these packages may define.
        without: names of the packages to leave out.
        findings: receives the errors and notes.
        failed: whether the expansion failed; then every missing package counts as needed.
    """
    needed = [each.name for each in absent[:MAX_NAMED] if (each.includes or failed) and each.name not in without]
    macros = list(dict.fromkeys(printable(call.macro) for call in calls[:MAX_NAMED]))
    for package in absent[:MAX_NAMED]:
        if not package.includes and not failed:
            text = f"no package {package.name!r}: $(find {package.name}) expands to {SCHEME}{package.name}"
            findings.add("N103", text, package.span)
            continue
        brings = [listing(map(printable, package.includes), "includes")] if package.includes else []
        brings += [listing(macros, "macros that are called but not defined")] if macros else []
        if package.name in without:
            findings.add("N103", f"left out on request: package {package.name!r}", package.span, *brings)
            continue
        text, *remedies = map(printable, package.lacks or [f"no package {package.name!r}"])
        findings.add("S103", f"xacro: {text}", package.span, *brings, *remedies, _leaving_out(package.name, needed))


def report_mesh_packages(root: Element, packages: Packages, findings: Findings) -> None:
    """Add one error for each missing package to which meshes refer, instead of one error for each mesh."""
    missing: dict[str, dict[str, Element]] = {}
    for mesh in root.walk():
        name = package_of(mesh.get("filename")) if mesh.tag == "mesh" else None
        if name is None or packages.find(name) is not None:
            continue
        places = packages.places(mesh.get("filename"))  # a package may lie in a folder of another name
        if not any(packages.files.may_read(place) and place.is_file() for place in places):
            missing.setdefault(name, {}).setdefault(mesh.get("filename"), mesh)
    for name, meshes in missing.items():
        text, *remedies = packages.lacks(name)
        alternative = _leaving_out(name, [*missing])
        names = listing((printable(reference) for reference in meshes), "meshes")
        findings.add("S101", text, next(iter(meshes.values())).place("filename"), names, *remedies, alternative)


def _leaving_out(name: str, needed: Sequence[str]) -> str:
    """Return the remedy for a missing package: its option, or for the last of several the options for all of them."""
    if name != needed[-1]:
        return ""
    options = " ".join(f"--without {quoted(each)}" for each in needed)
    return f"or leave out {'the package' if len(needed) == 1 else f'all {len(needed)} packages'}: {options}"


def drop_meshes(root: Element, packages: Collection[str], findings: Findings) -> None:
    """Remove the visuals and colliders whose meshes are in the given packages."""
    prefixes = tuple(f"{SCHEME}{name}/" for name in packages)
    for link in root.all("link"):
        for part in [part for part in link.children if _names_one(part, prefixes)]:
            link.children.remove(part)
            text = f"left out on request: a {part.tag} of link {printable(link.get('name'))!r}"
            findings.add("N103", text, part.span)


def _names_one(part: Element, prefixes: tuple[str, ...]) -> bool:
    return any(shape.tag == "mesh" and shape.get("filename").startswith(prefixes) for shape in part.walk())
