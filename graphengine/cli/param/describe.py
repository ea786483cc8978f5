"""`graphrun param describe`: print the types, descriptions and limits of parameters."""

from __future__ import annotations

import argparse
from typing import Any

from graphengine.cli.live import Live, add_live_arguments, show
from graphengine.cli.param.nodes import add_node_argument, client_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun param describe` to its parser."""
    add_node_argument(parser)
    parser.add_argument(
        "parameters", metavar="PARAMETER", nargs="+", help="name, such as cmd_vel.DiffController.maxLinearSpeed"
    )
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the descriptors of the parameters; return 0."""
    with Live(arguments) as live:
        for descriptor in client_of(live, arguments.node).describe(arguments.parameters):
            show(text(descriptor))
    return 0


def text(descriptor: Any) -> str:
    """Return a ParameterDescriptor as `ros2 param describe` prints it."""
    lines = [f"Parameter name: {descriptor.name}", f"  Type: {type_name(descriptor.type)}"]
    if descriptor.description:
        lines.append(f"  Description: {descriptor.description}")
    lines.append("  Constraints:")
    if descriptor.read_only:
        lines.append("    Read only: true")
    for limits in (*descriptor.floating_point_range, *descriptor.integer_range)[:1]:
        lines += [f"    Min value: {limits.from_value}", f"    Max value: {limits.to_value}"]
        if limits.step:
            lines.append(f"    Step: {limits.step}")
    if descriptor.additional_constraints:
        lines.append(f"    Additional constraints: {descriptor.additional_constraints}")
    return "\n".join(lines)


def type_name(kind: int) -> str:
    """Return the name of a parameter type as `ros2 param` prints it."""
    from graphengine.messages.parameters import ParameterType

    name = ParameterType(kind).name if kind in ParameterType._value2member_map_ else "NOT_SET"
    return name.lower().replace("_", " ").replace("bool", "boolean")
