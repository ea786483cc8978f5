"""`graphrun import-urdf`: make a robot file from a URDF, a xacro file, or the description of a running ROS 2 system."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import (
    add_repeatable,
    add_transport_argument,
    clean,
    counted,
    print_findings,
    refuse_to_overwrite,
)
from graphengine.cli.progress import progress
from graphengine.cli.quantities import duration
from graphengine.format.atomic_write import write_together
from graphengine.format.diagnostics import Findings
from graphengine.format.errors import UsageError
from graphengine.format.files import Files, installed_packages, near, require_file
from graphengine.format.wording import listing
from graphengine.ros.domain import Domain

if TYPE_CHECKING:
    from graphengine.physics.description.urdf import Urdf, Wheel
    from graphengine.physics.model.importing import Imported, Origin

WAIT = 10.0
"""Seconds that a description from the network is waited for."""
LONGEST_WAIT = 1e6
TOPIC = "/robot_description"
LONGEST = 10
"""Lines of one kind that the report tells; the robot file has all."""
WIDEST = 160
"""Characters of such a line."""
FORWARDS = 0.999
"""Least cosine of the angle between a wheel's axle and the robot's y axis, for a robot that drives straight."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.add_argument(
        "file", metavar="URDF|XACRO", nargs="?", help="robot description file; or use --topic or --node"
    )
    parser.add_argument("arguments", metavar="NAME:=VALUE", nargs="*", help="arguments of a xacro file")
    parser.add_argument("-o", "--output", metavar="FILE", type=Path, required=True, help="robot file to write")
    parser.add_argument("--force", action="store_true", help="overwrite existing files")
    source = parser.add_mutually_exclusive_group()
    source.add_argument(
        "--topic", nargs="?", const=TOPIC, help=f"read the description from a latched topic (default {TOPIC})"
    )
    source.add_argument("--node", help="read the description from the parameter robot_description of a node")
    parser.add_argument(
        "--timeout",
        metavar="TIME",
        type=duration,
        default=WAIT,
        help=f"longest wait for the network (default {WAIT:g}s)",
    )
    add_transport_argument(parser, " for --topic and --node")
    parser.add_argument("--fixed-base", action="store_true", help="fix the root link to the world, as for an arm")
    packages = "folder of a ROS package or of several packages; files in it may be read"
    add_repeatable(parser, "--package-path", "FOLDER", packages, type=Path)
    add_repeatable(parser, "--allow", "FOLDER", "additional folder that may be read", type=Path)
    parse = parser.parse_known_args

    def parse_in_any_order(given: Sequence[str], namespace: argparse.Namespace) -> tuple[argparse.Namespace, list[str]]:
        """Parse arguments in any order; argparse would take xacro arguments in one place only."""
        parsed, unknown = parse([text for text in given if ":=" not in text], namespace)
        parsed.arguments = [*parsed.arguments, *(text for text in given if ":=" in text)]
        return parsed, unknown

    parser.parse_known_args = parse_in_any_order  # type: ignore[method-assign, assignment]


def execute(arguments: argparse.Namespace) -> int:
    """Write the robot file; return 0 on success, 1 if the description has errors (which are reported)."""
    from graphengine.physics.model.importing import import_robot

    _check_usage(arguments)
    findings = Findings()
    origin = _origin(arguments, findings)
    with progress("importing"):
        imported = import_robot(origin, findings) if origin is not None else None
    print_findings(findings, notes=False)
    if imported is None:
        print(f"{arguments.output} is not written", file=sys.stderr)
        return 1
    refuse_to_overwrite(imported.files, force=arguments.force)
    write_together({path: text.encode() for path, text in imported.files.items()})
    _report(imported, findings)
    return 0


def _check_usage(arguments: argparse.Namespace) -> None:
    """Check the arguments before anything is read.

    Raises:
        UsageError: the arguments are invalid.
    """
    remote = arguments.topic or arguments.node
    if bool(arguments.file) == bool(remote):
        raise UsageError("give a file, --topic or --node, and only one of them")
    if remote and arguments.arguments:
        raise UsageError(
            f"{arguments.arguments[0]}: only a xacro file takes arguments, not a description from the network"
        )
    for text in arguments.arguments:
        if not re.match(r"[^:=]+:=", text):
            raise UsageError(f"{text}: write NAME:=VALUE, as for xacro")
    if arguments.output.suffix not in (".yaml", ".yml"):
        raise UsageError(f"-o {arguments.output}: a robot file ends in .yaml")
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", arguments.output.stem):
        raise UsageError(
            f"-o {arguments.output}: the robot gets the name of the file, which may have letters, digits and '_' only"
        )
    for folder in (*arguments.allow, *arguments.package_path):
        if not folder.is_dir():
            raise UsageError(f"no folder {str(folder)!r}")
    if not 0 < arguments.timeout <= LONGEST_WAIT:
        raise UsageError(f"--timeout: write more than 0 s and at most {LONGEST_WAIT:g} s")
    refuse_to_overwrite((arguments.output,), force=arguments.force)


def _origin(arguments: argparse.Namespace, findings: Findings) -> Origin | None:
    """Read the given description; None after an error."""
    from graphengine.physics.files.packages import Packages
    from graphengine.physics.files.xml import parse
    from graphengine.physics.model.importing import Origin

    target, fixed = arguments.output, arguments.fixed_base
    if arguments.file:
        return _from_file(arguments, findings)
    text, told = _remote(arguments)
    element = parse(text.encode(), told, findings, "S103")
    if element is None:
        return None
    packages = Packages(target.absolute().parent, arguments.package_path, _files(target, arguments))
    return Origin(element, packages, None, told, target, fixed)


def _from_file(arguments: argparse.Namespace, findings: Findings) -> Origin | None:
    from graphengine.physics.description import xacro
    from graphengine.physics.files.packages import Packages
    from graphengine.physics.files.xml import read
    from graphengine.physics.model.importing import Origin

    path = Path(near(arguments.file))
    require_file(path)
    element = read(path, findings, "S103")
    if element is None:
        return None
    packages = Packages(path.parent, arguments.package_path, _files(path, arguments))
    source: Path | None = path
    if xacro.is_xacro(path, element):
        if path.resolve() == arguments.output.with_suffix(".urdf").resolve():
            raise UsageError(
                f"-o {arguments.output}: the URDF written beside it would overwrite {path}; choose another name"
            )
        given = dict(text.split(":=", 1) for text in arguments.arguments)
        element, source = xacro.expand(path, given, packages, findings), None
    elif arguments.arguments:
        raise UsageError(f"{arguments.arguments[0]}: {path} does not use xacro")
    if element is None:
        return None
    told = " ".join([str(path), *arguments.arguments])
    return Origin(element, packages, source, told, arguments.output, arguments.fixed_base)


def _files(given: Path, arguments: argparse.Namespace) -> Files:
    """The files that may be read: the description's package, and those allowed on the command line."""
    package = next((folder for folder in given.absolute().parents if (folder / "package.xml").is_file()), None)
    allowed = [*arguments.allow, *arguments.package_path, *([package] if package is not None else [])]
    return Files.of(given, allowed, Path.cwd(), installed_packages())


def _remote(arguments: argparse.Namespace) -> tuple[str, str]:
    """The description from the network, and its source."""
    from graphengine.ros import description
    from graphengine.ros.transport import JoinOptions
    from graphengine.ros.transports.select import open_transport

    domain = Domain.from_environment(os.environ)
    transport = open_transport(arguments.transport, JoinOptions(domain, "graphrun_import_urdf", environ=os.environ))
    try:
        print(f"waiting for {arguments.node or arguments.topic}; {transport.description}", file=sys.stderr)
        if arguments.node:
            text = description.from_node(transport, arguments.node, arguments.timeout)
            return text, f"parameter {description.PARAMETER} of {arguments.node}"
        return description.from_topic(transport, arguments.topic, arguments.timeout), f"topic {arguments.topic}"
    finally:
        transport.close()


def _report(imported: Imported, findings: Findings) -> None:
    """Print a report on the imported robot."""
    from collections import Counter

    from graphengine.physics.description.robot_file_writer import left_behind
    from graphengine.physics.description.urdf import track

    robot, urdf = imported.robot, imported.robot.urdf
    rolling = urdf.wheels(urdf.moving())
    base = "free" if imported.free else "fixed to the world"
    if imported.free and not rolling:
        base += "; --fixed-base bolts it to the world"
    links, joints = counted(len(urdf.links), "link"), counted(len(urdf.joints), "joint")
    lines = [f"wrote {', '.join(near(str(path)) for path in imported.files)}"]
    lines += [f"{links}, {joints} of which {len(robot.moving)} move, {urdf.mass:.4g} kg"]
    lines += [f"base link {urdf.root}, {base}"]
    if imported.lowest is not None:
        lines.append(f"lowest collider at z = {imported.lowest:.4f} m, all joints at zero")
    outcomes = Counter(imported.library.outcomes.values())
    lines.append(f"meshes: {', '.join(f'{number} {what}' for what, number in sorted(outcomes.items())) or 'none'}")
    lines += [f"wheel on {wheel.joint}: radius {wheel.radius:g} m" for wheel in rolling]
    if (distance := track(rolling)) is not None:
        lines.append(f"track {distance:g} m")
    if followers := [joint.name for joint in robot.moving if joint.mimic is not None]:
        lines.append(listing(followers, "joints that follow another"))
    notes = [finding for finding in findings.items if finding.severity == "note"]
    lines += _some("note", [": ".join([note.message, *note.help]) for note in notes])
    lines += _some("not carried over", left_behind(urdf))
    if imported.outside:
        allowed = " ".join(f"--allow {near(str(folder))}" for folder in imported.outside)
        lines.append(f"scenes with this robot read files outside of their folder: run them with {allowed}")
    lines.append(f"in a scene: {_example(imported)}")
    if imported.free and (drive := _drive(urdf, rolling)):
        lines.append(f"in its file, to drive it: {drive}")
    print(clean("\n".join(line.replace("\n", " ") for line in lines)))


def _example(imported: Imported) -> str:
    """An example scene with the robot on the floor."""
    lift = math.ceil(round(-(imported.lowest or 0.0), 4) * 1000) / 1000
    place = f", position: [0, 0, {lift:g}]" if imported.free and lift else ""
    return f"robots: {{{imported.robot.name}: {{use: {imported.use}{place}}}}}"


def _drive(urdf: Urdf, rolling: Sequence[Wheel]) -> str:
    """An example graph for a robot with two parallel wheels that turn forward about its y axis; else an empty string."""
    from graphengine.devices.rotation import rotate
    from graphengine.physics.description.urdf import track

    poses = [urdf.pose_in_root(urdf.joints[wheel.joint].child) for wheel in rolling]
    axles = [rotate(pose[1], urdf.joints[wheel.joint].axis) for pose, wheel in zip(poses, rolling, strict=True)]
    if len(rolling) != 2 or any(axle[1] < FORWARDS for axle in axles) or (distance := track(rolling)) is None:
        return ""
    left, right = sorted(rolling, key=lambda wheel: -wheel.along)
    values = f"wheels: [{left.joint}, {right.joint}], radius: {left.radius:.7g}, distance: {distance:.7g}"
    return f"graphs: {{drive: {{use: graphs/drive.yaml, parameters: {{base: {urdf.root}, {values}}}}}}}"


def _some(what: str, items: Sequence[str]) -> list[str]:
    """Lines for the first items, each cut to a maximum length."""
    shown = [f"{what}: {item if len(item) <= WIDEST else f'{item[: WIDEST - 1]}…'}" for item in items[:LONGEST]]
    return [*shown, *([f"{what}: … ({len(items) - LONGEST} more)"] if len(items) > LONGEST else [])]
