"""Finds conflicts of this installation: changed or foreign files, and another distribution with the same package."""

from __future__ import annotations

import base64
import csv
import hashlib
from importlib import metadata
from pathlib import Path

from graphengine.format.distribution import NAME, PACKAGE, reinstall_command

_SHOWN = 2
"""Maximum number of files that a conflict lists."""


def conflicts() -> tuple[list[str], list[str]]:
    """Look for another distribution with this package, and for files that differ from the distribution `graphrun`.

    Returns:
        One line for each conflict, and the commands that repair the conflicts; both are empty without a conflict.
    """
    found, remedies = list[str](), list[str]()
    other, own = _installed(PACKAGE), _installed(NAME)
    if other is not None:
        ours = other.entry_points.select(group="console_scripts", name=NAME)
        whose = f"the old name of {NAME}" if ours else f"another project with a package {PACKAGE}"
        found.append(f"the distribution {PACKAGE} {other.version} in {other.locate_file('')}: {whose}")
    foreign, damaged = _unlike(own) if own else ([], [])
    if foreign:
        found.append(f"files that are not of {NAME}: {_listing(foreign)}")
        if other is None:
            remedies.append("delete the files that are not of it")
    if damaged:
        found.append(f"files of {NAME} that were changed or removed: {_listing(damaged)}")
    if other or damaged:
        installed = {each.name: each.read_text("direct_url.json") or "" for each in (other, own) if each}
        editable = any('"editable": true' in text for text in installed.values())
        remedies += [f"pip uninstall -y {' '.join(installed)}", reinstall_command(editable=editable)]
    return found, remedies


def _installed(name: str) -> metadata.Distribution | None:
    try:
        return metadata.distribution(name)
    except metadata.PackageNotFoundError:
        return None


def _unlike(own: metadata.Distribution) -> tuple[list[Path], list[Path]]:
    """Compare the package's folder with the RECORD of a distribution.

    Returns:
        Files that the RECORD does not list, and listed files that are missing or have other bytes.
    """
    rows = csv.reader((own.read_text("RECORD") or "").splitlines())
    listed = {Path(str(own.locate_file(path))): digest for path, digest, _ in rows if path.startswith(f"{PACKAGE}/")}
    there = {path for path in Path(str(own.locate_file(PACKAGE))).rglob("*") if path.is_file()} if listed else set()
    foreign = {path for path in there - listed.keys() if "__pycache__" not in path.parts}
    damaged = {path for path, digest in listed.items() if digest and (path not in there or _digest(path) != digest)}
    return sorted(foreign), sorted(damaged)


def _digest(path: Path) -> str:
    """Return the digest of a file in the format of a RECORD."""
    digest = hashlib.sha256(path.read_bytes()).digest()
    return f"sha256={base64.urlsafe_b64encode(digest).rstrip(b'=').decode()}"


def _listing(paths: list[Path]) -> str:
    """Return the first paths of a list, and the number of the other paths, as text."""
    more = f" and {len(paths) - _SHOWN} more" if len(paths) > _SHOWN else ""
    return ", ".join(map(str, paths[:_SHOWN])) + more
