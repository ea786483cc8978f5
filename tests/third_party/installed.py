"""Packages of others as pip would leave them in a folder; it needs no network."""

from __future__ import annotations

import tomllib
from pathlib import Path


def lay_out(package: Path, module: str, folder: Path) -> None:
    """Put a module and the metadata of its package into a folder of installed packages."""
    (folder / module).symlink_to(package / module)
    describe(package, folder)


def describe(package: Path, folder: Path) -> None:
    """Put the metadata of a package into a folder of installed packages."""
    project = tomllib.loads((package / "pyproject.toml").read_text())["project"]
    about = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n")
    groups = project["entry-points"].items()
    lines = [line for name, entries in groups for line in (f"[{name}]", *(f"{k} = {v}" for k, v in entries.items()))]
    (about / "entry_points.txt").write_text("\n".join(lines) + "\n")
