"""`graphrun new`: create a project folder with a robot, its graphs, a scene and a test."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

from graphengine.cli import import_urdf
from graphengine.cli.common import clean, print_findings
from graphengine.cli.import_report import report
from graphengine.cli.options import add_value
from graphengine.cli.progress import progress
from graphengine.cli.project import WORLDS, Project
from graphengine.cli.stage_project import make, read_whole
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import USD, near, require_file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun new` to its parser."""
    add_value(parser, "folder", "DIR", "folder to create; it must be empty or not exist", type=Path)
    description = "robot description file (default: use the included Clearpath Dingo-D)"
    add_value(parser, "--from", "URDF|XACRO|SDF|MJCF|USD", description, dest="file")
    parser.add_argument("--world", choices=WORLDS, help="world of the scene (default: table for an arm, else flat)")
    import_urdf.add_source_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Write the project; return 0 on success, 1 if the description has errors, which are printed."""
    project = Project(arguments.folder, _name(arguments.folder), arguments.world)
    if arguments.folder.exists() and (not arguments.folder.is_dir() or any(arguments.folder.iterdir())):
        raise UsageError(f"{arguments.folder}: this is not an empty folder; give an empty or a new folder")
    if not (arguments.file or arguments.topic or arguments.node):
        if arguments.arguments:
            raise UsageError(f"{arguments.arguments[0]}: only a xacro file takes arguments; give one with --from FILE")
        project.add_dingo()
        project.write()
        print(project.told())
        return 0
    return _from_description(arguments, project)


def _from_description(arguments: argparse.Namespace, project: Project) -> int:
    from graphengine.cli.first_run import SECONDS, first_run

    findings = Findings()
    if arguments.file and Path(near(arguments.file)).suffix in USD:
        path = Path(near(arguments.file))
        require_file(path)
        stage = read_whole(arguments, path, findings)
        if stage is None or findings.errors:
            print_findings(findings, notes=False)
            print(f"{project.folder} is not written", file=sys.stderr)
            return 1
        if stage.whole:
            return make(arguments, project, stage, findings)
        findings = Findings()
    imported = import_urdf.import_source(arguments, project.robot_file, findings, path=None, bundled=True)
    if imported is None:
        print(f"{project.folder} is not written", file=sys.stderr)
        return 1
    project.add_robot(imported)
    project.write()
    print(clean("\n".join([*report(imported, findings), *import_urdf.corrections(imported, project.robot_file)])))
    with progress("running for 2 s"):
        said = first_run(project.scene_file, project.name, holds=project.holds)
    print(clean("\n".join(f"in a run of {SECONDS:g} s: {line}" for line in said)), end="\n" if said else "")
    print(project.told())
    return 0


def _name(folder: Path) -> str:
    """Return the name of the robot: the folder's name, with `_` in place of characters other than letters, digits and `_`.

    Raises:
        UsageError: the resulting name does not begin with a letter.
    """
    name = re.sub(r"[^A-Za-z0-9_]+", "_", folder.absolute().name).strip("_")
    if not re.match(r"[A-Za-z]", name):
        raise UsageError(f"{folder}: the robot gets the name of the folder, which must begin with a letter")
    return name
