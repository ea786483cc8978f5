"""`graphrun param get`: print the value of a parameter."""

from __future__ import annotations

import argparse
from typing import Any

from graphengine.cli.live import Live, add_live_arguments, show
from graphengine.cli.param.nodes import add_node_argument, add_parameter_argument, client_of
from graphengine.format.errors import TransportError

_LABELS = {
    "BOOL": "Boolean value is:",
    "INTEGER": "Integer value is:",
    "DOUBLE": "Double value is:",
    "STRING": "String value is:",
    "BYTE_ARRAY": "Byte values are:",
    "BOOL_ARRAY": "Boolean values are:",
    "INTEGER_ARRAY": "Integer values are:",
    "DOUBLE_ARRAY": "Double values are:",
    "STRING_ARRAY": "String values are:",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun param get` to its parser."""
    add_node_argument(parser)
    add_parameter_argument(parser)
    parser.add_argument("--hide-type", action="store_true", help="print only the value")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Print the value; return 0.

    Raises:
        TransportError: there is no such node, or the parameter is not set.
    """
    from graphengine.format.wording import did_you_mean
    from graphengine.messages.parameters import python_value

    with Live(arguments) as live:
        client = client_of(live, arguments.node)
        found = client.get([arguments.parameter])
        value = python_value(found[0]) if found else None
        if value is None:
            near = did_you_mean(arguments.parameter, client.list())
            raise TransportError("\n".join(filter(None, (f"parameter not set: {arguments.parameter!r}", near))))
        show(str(value) if arguments.hide_type else f"{label(found[0])} {value}")
    return 0


def label(message: Any) -> str:
    """Return the label that `ros2 param get` prints before a ParameterValue."""
    from graphengine.messages.parameters import type_of

    return _LABELS[type_of(message).name]
