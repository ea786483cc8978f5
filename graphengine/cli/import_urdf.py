"""`graphrun import-robot`: make a robot file from a URDF, xacro, SDF, MJCF or USD file, or from a running ROS 2 system.

The former name of this verb is `import-urdf`.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import add_transport_argument, clean, print_findings, refuse_to_overwrite
from graphengine.cli.import_report import example, report
from graphengine.cli.options import add_flag, add_repeatable, add_value, split_arguments
from graphengine.cli.progress import progress
from graphengine.cli.quantities import duration
from graphengine.format.atomic_write import write_together
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import GraphError, UsageError
from graphengine.format.files import USD, Files, installed_packages, near, require_file, require_suffix
from graphengine.ros.domain import Domain

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported, Origin
    from graphengine.descriptions.robot_description import RobotDescription
    from graphengine.descriptions.usd.stage_files import StageChoice

WAIT = 10.0
"""Default time to wait for a description from the network, s."""
LONGEST_WAIT = 1e6
"""Longest value of the option `--timeout`, s."""
TOPIC = "/robot_description"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun import-robot` to its parser."""
    description = "robot description file; without a file, give --topic or --node"
    add_value(parser, "file", "URDF|XACRO|SDF|MJCF|USD", description, nargs="?")
    add_value(parser, "--output", "FILE", "robot file to write, such as my_robot.yaml", short="-o", type=Path)
    add_flag(parser, "--args", "list the arguments of a xacro file and write no files", dest="list_arguments")
    add_flag(parser, "--force", "overwrite existing files")
    add_source_arguments(parser)


def add_source_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments for the source of a robot description and for reading it, except the argument for its file."""
    add_value(parser, "arguments", "NAME:=VALUE", "argument of the xacro file", nargs="*", default=[])
    source = parser.add_mutually_exclusive_group()
    latched = f"read the description from a latched topic (default {TOPIC})"
    source.add_argument("--topic", nargs="?", const=TOPIC, help=latched)
    source.add_argument("--node", help="read the description from the parameter robot_description of this node")
    wait = f"maximum time to wait for --topic or --node, such as 10s (default {WAIT:g}s)"
    add_value(parser, "--timeout", "TIME", wait, type=duration, default=WAIT)
    add_transport_argument(parser, " for --topic and --node")
    add_value(
        parser,
        "--controllers",
        "FILE",
        "parameter file of ros2_control, such as ros2_controllers.yaml; its controllers show how the base is driven",
        type=Path,
    )
    model = "model of the SDF file, or prim of the USD stage, to import (default: the only one)"
    add_value(parser, "--model", "NAME", model, default="")
    variant = "select a variant of the USD stage, as SET=NAME or PRIM:SET=NAME"
    add_repeatable(parser, "--variant", "SET=NAME", variant)
    assets = "look up assets on servers, such as omniverse://, by the end of their path in this folder; none is fetched"
    add_repeatable(parser, "--assets", "FOLDER", assets, type=Path)
    add_repeatable(parser, "--replace", "REFERENCE=FILE", "use a file in place of a reference of the USD stage")
    add_value(parser, "--macro", "NAME", "macro of the xacro file that defines the robot")
    left_out = "leave out everything from this package: included files, their macros, meshes"
    add_repeatable(parser, "--without", "PACKAGE", left_out)
    drives = "add position drives to joints that take efforts, to hold them; gains follow from the mass matrix (not for MJCF)"
    add_flag(parser, "--position-drives", drives)
    add_flag(parser, "--fixed-base", "fix the root link to the world, as for an arm")
    packages = "ROS package or Gazebo model to which package:// and model:// refer, or a folder with several"
    add_repeatable(parser, "--package-path", "FOLDER", packages, type=Path)
    add_repeatable(parser, "--allow", "FOLDER", "also let the description refer to files in this folder", type=Path)
    split_arguments(parser, _without_xacro_arguments)  # argparse expects positional arguments in one place


def _without_xacro_arguments(words: list[str]) -> tuple[list[str], list[str]]:
    """Return the words that are not xacro arguments (NAME:=VALUE), and the xacro arguments."""
    return [word for word in words if ":=" not in word], [word for word in words if ":=" in word]


def execute(arguments: argparse.Namespace) -> int:
    """Write the robot file, or with `--args` list the xacro arguments; return 0, or 1 if the description has errors."""
    if arguments.list_arguments:
        return _list_arguments(arguments)
    _check_output(arguments)
    findings = Findings()
    imported = import_source(arguments, arguments.output, findings)
    if imported is None:
        print(f"{arguments.output} is not written", file=sys.stderr)
        return 1
    refuse_to_overwrite(imported.files, force=arguments.force)
    write_together({path: text.encode() for path, text in imported.files.items()})
    lines = [*report(imported, findings), *corrections(imported, arguments.output), example(imported)]
    print(clean("\n".join(lines)))
    return 0


def import_source(arguments: argparse.Namespace, target: Path, findings: Findings, **changes: Any) -> Imported | None:
    """Import the robot of the given source, and print errors and warnings; return None after an error.

    Args:
        arguments: arguments that `add_source_arguments` added, and `file`.
        target: path of the robot file to write.
        findings: receives errors, warnings and notes.
        changes: fields of the `Origin` to change before the import.

    Raises:
        UsageError: not exactly one source is given, options do not apply to the source, or a value is invalid.
    """
    from graphengine.bringup.robots.import_robot import import_robot

    check_source(arguments)
    origin = find_origin(arguments, target, findings)
    with progress("importing"):
        imported = import_robot(replace(origin, **changes), findings) if origin is not None else None
    print_findings(findings, notes=False)
    return imported


def corrections(imported: Imported, robot_file: Path) -> list[str]:
    """Correct the track and the turn limit of a skid-steered robot in test drives; return lines on the changes."""
    told = imported.draft.controller_track
    if told is None or not imported.free:
        return []
    from graphengine.bringup.calibration.arc_track import correct_track, lower_turn

    robot = robot_file, imported.robot.name, imported.lift, imported.outside
    lines: list[str] = []
    with progress("measuring the track"):
        try:
            lines.append(correct_track(*robot, told=told))
            if "not measured" not in lines[0]:
                lines += lower_turn(*robot, guessed=imported.draft.guessed_turn)
        except GraphError as error:
            what = "arcs at the limits" if lines else "track"
            lines.append(f"{what}: not measured: {str(error).splitlines()[0]}")
    return lines


def _check_output(arguments: argparse.Namespace) -> None:
    """Check the file name given by `-o`.

    Raises:
        UsageError: a robot file cannot have this name, or the file exists and `--force` is not given.
    """
    if arguments.output is None:
        raise UsageError("give the robot file to write with -o FILE")
    if arguments.output.suffix not in (".yaml", ".yml"):
        raise UsageError(f"-o {arguments.output}: the name of a robot file ends in .yaml")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", arguments.output.stem):
        legal = "the robot gets the name of the file, which may have only letters, digits and '_'"
        raise UsageError(f"-o {arguments.output}: {legal}")
    refuse_to_overwrite((arguments.output,), force=arguments.force)


def check_source(arguments: argparse.Namespace) -> None:
    """Check the arguments that `add_source_arguments` added, before any file or topic is read.

    Raises:
        UsageError: not exactly one source is given, options do not apply to the source, or a value is invalid.
    """
    remote = arguments.topic or arguments.node
    if bool(arguments.file) == bool(remote):
        raise UsageError("give exactly one of a file, --topic and --node")
    if remote and arguments.arguments:
        reason = "only a xacro file takes arguments; a description from --topic or --node has none"
        raise UsageError(f"{arguments.arguments[0]}: {reason}")
    if remote and (arguments.macro or arguments.without):
        raise UsageError("--macro and --without need a file; they do not apply to a description from the network")
    for text in arguments.arguments:
        if not re.match(r"[^:=]+:=", text):
            raise UsageError(f"{text}: write an argument as NAME:=VALUE, as for xacro")
    for folder in (*arguments.allow, *arguments.package_path, *arguments.assets):
        if not folder.is_dir():
            raise UsageError(f"no folder {str(folder)!r}")
    if not 0 < arguments.timeout <= LONGEST_WAIT:
        raise UsageError(f"--timeout: write a time above 0 s, at most {LONGEST_WAIT:g} s")


def find_origin(arguments: argparse.Namespace, target: Path, findings: Findings) -> Origin | None:
    """Read and return the robot description and the controllers that the command line names; return None after an error.

    Args:
        arguments: arguments that `add_source_arguments` added, and `file`.
        target: path of the robot file to write.
        findings: receives errors and notes.
    """
    from graphengine.bringup.robots.controllers_file import load_parameters

    read = _from_file if arguments.file else _from_network
    origin = read(arguments, target, findings)
    if origin is not None and arguments.controllers is not None:
        path = Path(near(arguments.controllers))
        require_file(path)
        origin.packages.files.note(path)
        controllers = load_parameters(path, findings)
        origin = replace(origin, controllers=controllers) if not findings.errors else None
    return replace(origin, position_drives=arguments.position_drives) if origin is not None else None


def _from_network(arguments: argparse.Namespace, target: Path, findings: Findings) -> Origin | None:
    from graphengine.bringup.robots.import_robot import Origin
    from graphengine.descriptions.files.packages import Packages
    from graphengine.descriptions.files.xml import parse

    text, told = _remote(arguments)
    element = parse(text.encode(), told, findings, "S103")
    if element is None:
        return None
    packages = Packages(target.absolute().parent, arguments.package_path, _files(target, arguments))
    return Origin(element, packages, None, told, target, arguments.fixed_base)


def _from_file(arguments: argparse.Namespace, target: Path, findings: Findings) -> Origin | None:
    from graphengine.bringup.robots.import_robot import Origin
    from graphengine.bringup.robots.robot_source import Wishes, read_source
    from graphengine.descriptions.added_formats import read_root
    from graphengine.descriptions.files.packages import Packages
    from graphengine.descriptions.sdf.sdf_files import is_sdf
    from graphengine.descriptions.xacro import xacro

    path = Path(near(arguments.file))
    require_file(path)
    if path.suffix in USD:
        return _from_stage(arguments, path, target, findings)
    require_suffix(path, "import-robot")
    element = read_root(path, findings)
    if element is None:
        return None
    packages = Packages(path.parent, arguments.package_path, _files(path, arguments))
    if arguments.model and not is_sdf(element):
        raise UsageError(f"--model {arguments.model}: only SDF files contain several models, and {path} is not SDF")
    if element.tag == "mujoco":
        if given := [*arguments.arguments, *filter(None, [arguments.macro]), *arguments.without]:
            raise UsageError(f"{given[0]}: {path} is a MuJoCo model, which has no arguments, macros or packages")
        if arguments.position_drives:
            raise UsageError(f"--position-drives: {path} is a MuJoCo model, which has its own actuators")
        return Origin(element, packages, path, str(path), target, arguments.fixed_base, model=path)
    is_xacro = xacro.is_xacro(path, element)
    if is_xacro and path.resolve() == target.with_suffix(".urdf").resolve():
        raise UsageError(f"-o {target}: the URDF written beside it would overwrite {path}; choose another name")
    if not is_xacro and (given := [*arguments.arguments, *filter(None, [arguments.macro])]):
        raise UsageError(f"{given[0]}: {path} does not use xacro")
    values = dict(text.split(":=", 1) for text in arguments.arguments)
    wishes = Wishes(values, arguments.macro, arguments.without, arguments.model)
    source = read_source(path, element, target, wishes, packages, findings)
    if source is None:
        return None
    told = " ".join([str(path), *arguments.arguments])
    given_path = path if source.as_given else None
    return Origin(source.element, packages, given_path, told, target, arguments.fixed_base, wrapper=source.wrapper)


def stage_choice(arguments: argparse.Namespace, path: Path) -> tuple[Files, StageChoice]:
    """Return the files that a USD stage may read, and what the command line says to read of it.

    Raises:
        UsageError: an option does not apply to a stage, or usd-core is not installed.
    """
    from graphengine.descriptions.usd.stage_files import StageChoice, needed

    if given := [*arguments.arguments, *filter(None, [arguments.macro]), *arguments.without]:
        raise UsageError(f"{given[0]}: {path} is a USD stage, which has no arguments, macros or packages")
    if absent := needed():
        raise UsageError(absent)
    choice = StageChoice(
        arguments.model,
        _pairs(arguments.variant, "--variant SET=NAME or PRIM:SET=NAME"),
        {key: str(Path(file).resolve()) for key, file in _pairs(arguments.replace, "--replace REFERENCE=FILE").items()},
        [folder.resolve() for folder in arguments.assets],
    )
    around = [*choice.mirrors, *(Path(file).parent for file in choice.replaced.values())]
    return _files(path, arguments, around), choice


def stage_origin(
    arguments: argparse.Namespace, path: Path, target: Path, description: RobotDescription, choice: StageChoice
) -> Origin:
    """Return the origin of a robot of a stage whose description was read."""
    from graphengine.bringup.robots.import_robot import Origin

    fixed, packages = arguments.fixed_base, description.packages
    return Origin(
        description.element,
        packages,
        path,
        str(path),
        target,
        fixed,
        model=path,
        stage=description,
        choice=choice.keys(),
        position_drives=arguments.position_drives,
    )


def _from_stage(arguments: argparse.Namespace, path: Path, target: Path, findings: Findings) -> Origin | None:
    """Read a robot of a USD stage; return None after an error."""
    from graphengine.descriptions.usd.usd_reader import read_usd

    files, choice = stage_choice(arguments, path)
    description = read_usd(path, files, findings, choice)
    return stage_origin(arguments, path, target, description, choice) if description is not None else None


def _pairs(texts: Sequence[str], form: str) -> dict[str, str]:
    """Return the values of an option `KEY=VALUE` by key; raise UsageError if one has another form."""
    pairs = {text: text.rpartition("=") for text in texts}
    if wrong := next((text for text, (key, _, value) in pairs.items() if not (key and value)), ""):
        raise UsageError(f"{wrong}: write {form}")
    return {key: value for key, _, value in pairs.values()}


def _list_arguments(arguments: argparse.Namespace) -> int:
    """Print the arguments of a xacro file; return 0, or 1 if the file cannot be read."""
    from graphengine.bringup.robots.robot_source import arguments_of
    from graphengine.descriptions.added_formats import read_root
    from graphengine.descriptions.files.packages import Packages

    if not arguments.file:
        raise UsageError("--args: give a file; only a xacro file has arguments to list")
    path, findings = Path(near(arguments.file)), Findings()
    require_file(path)
    element = read_root(path, findings)
    if element is not None:
        packages = Packages(path.parent, arguments.package_path, _files(path, arguments))
        lines = arguments_of(path, element, packages, findings)
    print_findings(findings, notes=False)
    if findings.errors or element is None:
        return 1
    print(clean("\n".join(line.replace("\n", " ") for line in lines)))
    return 0


def _files(given: Path, arguments: argparse.Namespace, more: Sequence[Path] = ()) -> Files:
    """Return the access policy for files: the package or model folders around the description, and folders given by options."""
    from graphengine.descriptions.sdf.sdf_files import model_folders

    package = next((folder for folder in given.absolute().parents if (folder / "package.xml").is_file()), None)
    around = [package] if package is not None else model_folders(given)
    allowed = [*arguments.allow, *arguments.package_path, *around, *more]
    return Files.of(given, allowed, Path.cwd(), installed_packages())


def _remote(arguments: argparse.Namespace) -> tuple[str, str]:
    """Read the robot description from the topic or node; return its text and the name of the source for messages."""
    from graphengine.ros import description
    from graphengine.ros.transport import JoinOptions
    from graphengine.ros.transports.select import open_transport

    domain = Domain.from_environment(os.environ)
    transport = open_transport(arguments.transport, JoinOptions(domain, "graphrun_import_robot", environ=os.environ))
    try:
        print(f"waiting for {arguments.node or arguments.topic}; {transport.description}", file=sys.stderr)
        if arguments.node:
            text = description.from_node(transport, arguments.node, arguments.timeout)
            return text, f"parameter {description.PARAMETER} of {arguments.node}"
        return description.from_topic(transport, arguments.topic, arguments.timeout), f"topic {arguments.topic}"
    finally:
        transport.close()
