"""`graphrun param set`: set a parameter."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from graphengine.cli.common import clean
from graphengine.cli.live import Live, add_live_arguments, show
from graphengine.cli.param.nodes import add_node_argument, add_parameter_argument, client_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun param set` to its parser."""
    add_node_argument(parser)
    add_parameter_argument(parser)
    parser.add_argument("value", metavar="VALUE", help="value as YAML, such as 0.5 or '[1.0, 0.0, 0.0]'")
    add_live_arguments(parser)


def execute(arguments: argparse.Namespace) -> int:
    """Set the parameter; return 0, or 1 if the node refuses the value."""
    from graphengine.format import document
    from graphengine.format.diagnostics import Findings

    parsed = document.parse(arguments.value, "VALUE", Findings())
    with Live(arguments) as live:
        client = client_of(live, arguments.node)
        value = arguments.value if parsed is None or parsed.data is None else parsed.data
        (result,) = client.set([given(arguments.parameter, value, arguments.value)])
    return report(result, "Set parameter successful", "Setting parameter failed")


def given(name: str, value: Any, text: str) -> Any:
    """Return a Parameter message for a value.

    Args:
        name: name of the parameter.
        value: the value; its Python type determines the parameter type.
        text: value to send as a string if no parameter type fits.
    """
    from graphengine.messages.parameters import ParameterType, fitting_type, parameter_message

    kind = fitting_type(value)
    if kind is ParameterType.NOT_SET:
        return parameter_message(name, ParameterType.STRING, text)
    return parameter_message(name, kind, value)


def report(result: Any, done: str, failed: str) -> int:
    """Print a SetParametersResult with its reason; return the exit code: 0 on success, else 1.

    Args:
        result: the result of one parameter.
        done: text to print on success.
        failed: text to print on failure.
    """
    reason = f": {result.reason}" if result.reason else ""
    if result.successful:
        show(f"{done}{reason}")
        return 0
    print(clean(f"{failed}{reason}"), file=sys.stderr)
    return 1
