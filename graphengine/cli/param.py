"""`graphrun param`: read and set parameters of nodes on a live network, with or without ROS installed, like `ros2 param`."""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphengine.cli.common import clean
from graphengine.cli.live import Live, absolute, is_hidden, show
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.parameter_file import EVERY_NODE, KEY, nested, read
from graphengine.cli.subverbs import add_live_subverbs, reach_of
from graphengine.format.errors import TransportError, UsageError
from graphengine.format.wording import did_you_mean, listing
from graphengine.ros.network_graph import NetworkGraph

if TYPE_CHECKING:
    from graphengine.ros.parameter_client import ParameterClient

_BATCH = 500
"""Maximum number of parameters in one request."""
_LIST = "list_parameters"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subverbs with their arguments to the parser of the verb."""
    subverbs = {
        "list": ("list the parameters of a node, or of all nodes", _list_arguments, _list),
        "get": ("print the value of a parameter", _get_arguments, _get),
        "set": ("set a parameter", _set_arguments, _set),
        "describe": ("print the types, descriptions and limits of parameters", _describe_arguments, _describe),
        "dump": ("print all parameters of a node in the form of a YAML file", _add_node_argument, _dump),
        "load": ("set the parameters of a node from a YAML file", _load_arguments, _load),
    }
    offered = "A run offers the inputs of its nodes and the variables of its graphs as parameters."
    add_live_subverbs(parser, subverbs, f"{offered} {reach_of('nodes')}")


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    _add_node_argument(parser, optional=True)
    add_value(parser, "--filter", "REGEX", "list only parameters whose name begins with a match of this expression")
    add_flag(parser, "--include-hidden-nodes", "include nodes whose name begins with _")
    prefixes = "list only parameters with these prefixes, such as cmd_vel.DiffController"
    add_value(parser, "--param-prefixes", "PREFIX", prefixes, nargs="+", default=[])
    add_flag(parser, "--param-type", "also print the type of each parameter")


def _list(arguments: argparse.Namespace) -> int:
    """Print the parameters; return 0, or 1 if a node does not answer."""
    from graphengine.ros.parameter_client import ParameterClient

    try:
        wanted = re.compile(arguments.filter or "")
    except re.error as error:
        raise UsageError(f"--filter {arguments.filter}: {error}") from None
    code = 0
    with Live(arguments) as live:
        if arguments.node:
            clients = [_client_of(live, arguments.node)]
        else:
            nodes = _nodes_with_parameters(live.graph())
            nodes = [node for node in nodes if arguments.include_hidden_nodes or not is_hidden(node)]
            clients = [ParameterClient(live.transport, node, live.definitions) for node in nodes]
        for client in clients:
            try:
                names = [name for name in client.list(arguments.param_prefixes) if wanted.match(name)]
                kinds = client.describe(names) if arguments.param_type else ()
            except TransportError as error:
                print(clean(f"error: {error}"), file=sys.stderr)
                code = 1
                continue
            types = {each.name: f" (type: {_type_name(each.type)})" for each in kinds}
            lines = [f"  {name}{types.get(name, '')}" for name in names]
            if lines:
                show("\n".join(lines if arguments.node else [f"{client.node}:", *lines]))
        if not clients:
            live.say_none("nodes with parameters")
    return code


def _get_arguments(parser: argparse.ArgumentParser) -> None:
    _add_node_argument(parser)
    _add_parameter_argument(parser)
    add_flag(parser, "--hide-type", "print only the value")


def _get(arguments: argparse.Namespace) -> int:
    """Print the value; return 0.

    Raises:
        TransportError: there is no such node, or the parameter is not set.
    """
    from graphengine.messages.parameters import python_value

    with Live(arguments) as live:
        client = _client_of(live, arguments.node)
        found = client.get([arguments.parameter])
        value = python_value(found[0]) if found else None
        if value is None:
            near = did_you_mean(arguments.parameter, client.list())
            raise TransportError("\n".join(filter(None, (f"parameter not set: {arguments.parameter!r}", near))))
        show(str(value) if arguments.hide_type else f"{_label(found[0])} {value}")
    return 0


def _label(message: Any) -> str:
    """Return the label that `ros2 param get` prints before a ParameterValue."""
    kind, _, array = _type_name(message.type).partition(" ")
    return f"{kind.capitalize()} {'values are' if array else 'value is'}:"


def _set_arguments(parser: argparse.ArgumentParser) -> None:
    _add_node_argument(parser)
    _add_parameter_argument(parser)
    add_value(parser, "value", "VALUE", "value as YAML, such as 0.5 or '[1.0, 0.0, 0.0]'")


def _set(arguments: argparse.Namespace) -> int:
    """Set the parameter; return 0, or 1 if the node refuses the value."""
    from graphengine.format import document
    from graphengine.format.diagnostics import Findings

    parsed = document.parse(arguments.value, "VALUE", Findings())
    with Live(arguments) as live:
        client = _client_of(live, arguments.node)
        value = arguments.value if parsed is None or parsed.data is None else parsed.data
        (result,) = client.set([_given(arguments.parameter, value, arguments.value)])
    return report(result, "Set parameter successful", "Setting parameter failed")


def _given(name: str, value: Any, text: str) -> Any:
    """Return a Parameter message for a value.

    Args:
        name: name of the parameter.
        value: the value; its Python type determines the parameter type.
        text: text of the value, which is sent as a string if no parameter type fits the value.
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


def _describe_arguments(parser: argparse.ArgumentParser) -> None:
    _add_node_argument(parser)
    _add_parameter_argument(parser, "parameters", nargs="+")


def _describe(arguments: argparse.Namespace) -> int:
    """Print the descriptors of the parameters; return 0."""
    with Live(arguments) as live:
        for descriptor in _client_of(live, arguments.node).describe(arguments.parameters):
            show(_text(descriptor))
    return 0


def _text(descriptor: Any) -> str:
    """Return a ParameterDescriptor as `ros2 param describe` prints it."""
    lines = [f"Parameter name: {descriptor.name}", f"  Type: {_type_name(descriptor.type)}"]
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


def _type_name(kind: int) -> str:
    """Return the name of a parameter type as `ros2 param` prints it."""
    from graphengine.messages.parameters import ParameterType

    name = ParameterType(kind).name if kind in ParameterType._value2member_map_ else "NOT_SET"
    return name.lower().replace("_", " ").replace("bool", "boolean")


def _dump(arguments: argparse.Namespace) -> int:
    """Print the parameters as YAML; return 0."""
    import yaml

    with Live(arguments) as live:
        client = _client_of(live, arguments.node)
        values = current(client)
    show(yaml.dump({client.node: {KEY: nested(values)}}, default_flow_style=False))
    return 0


def current(client: ParameterClient) -> dict[str, Any]:
    """Return a dict from the names of a node's parameters to their values; parameters without a value are left out."""
    from graphengine.messages.parameters import python_value

    names = client.list()
    answers = [client.get(names)]
    if len(answers[0]) != len(names):  # as one of them has no value
        answers = [client.get([name])[:1] for name in names]
        names = [name for name, answer in zip(names, answers, strict=True) if answer]
    found = [python_value(value) for answer in answers for value in answer]
    return {name: value for name, value in zip(names, found, strict=True) if value is not None}


def _load_arguments(parser: argparse.ArgumentParser) -> None:
    _add_node_argument(parser)
    add_value(parser, "file", "FILE", "YAML file in the form that `graphrun param dump` prints", type=Path)
    add_flag(parser, "--no-use-wildcard", f"ignore the parameters below {EVERY_NODE}, which are for all nodes")


def _load(arguments: argparse.Namespace) -> int:
    """Set the parameters; return 0, or 1 if the node refuses one."""
    values = read(arguments.file, wildcard=not arguments.no_use_wildcard)
    with Live(arguments) as live:
        client = _client_of(live, arguments.node)
        code, names = 0, list(values)
        for first in range(0, len(names), _BATCH):
            batch = names[first : first + _BATCH]
            results = client.set([_given(name, values[name], str(values[name])) for name in batch])
            for name, result in zip(batch, results, strict=True):
                code |= report(result, f"Set parameter {name} successful", f"Set parameter {name} failed")
    return code


def _add_node_argument(parser: argparse.ArgumentParser, *, optional: bool = False) -> None:
    """Add the positional argument NODE; with `optional`, the user may leave it out to choose all nodes."""
    text = "node, such as /dd100_0000/dd100" + (" (default: all nodes)" if optional else "")
    add_value(parser, "node", "NODE", text, nargs="?" if optional else None)


def _add_parameter_argument(parser: argparse.ArgumentParser, name: str = "parameter", **more: Any) -> None:
    """Add the positional argument PARAMETER with the attribute `name`."""
    what = "name, such as cmd_vel.DiffController.maxLinearSpeed"
    parser.add_argument(name, metavar="PARAMETER", help=what, **more)


def _nodes_with_parameters(graph: NetworkGraph) -> list[str]:
    """Return the full names of the nodes that offer parameters, sorted."""
    from graphengine.messages.parameters import SERVICES

    return [name.removesuffix(f"/{_LIST}") for name, kind in graph.services if kind == SERVICES[_LIST]]


def _client_of(live: Live, given: str) -> ParameterClient:
    """Return a client of a node's parameters.

    Args:
        live: connection to the network.
        given: name of the node, with or without the leading slash.

    Raises:
        TransportError: there is no such node, or it has no parameters.
    """
    from graphengine.ros.parameter_client import ParameterClient

    node = absolute(given)
    graph = live.graph(lambda graph: node in _nodes_with_parameters(graph))
    known = _nodes_with_parameters(graph)
    if node not in known:
        near = did_you_mean(node, known) or listing(known, "nodes with parameters")
        raise TransportError(f"no node {node!r} with parameters\n{near}\nsearched {live.where}")
    return ParameterClient(live.transport, node, live.definitions)
