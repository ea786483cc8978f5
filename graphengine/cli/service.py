"""`graphrun service`: list and call services on a live network, with or without ROS installed, like `ros2 service`."""

from __future__ import annotations

import argparse
import sys
import time

from graphengine.cli.live import Live, absolute, add_message_arguments, is_hidden, near_topic, show, types_by_name
from graphengine.cli.options import add_flag, add_value
from graphengine.cli.quantities import positive
from graphengine.cli.subverbs import add_live_subverbs, reach_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subverbs with their arguments to the parser of the verb."""
    subverbs = {
        "list": ("list services that have a server or client", _list_arguments, _list),
        "type": ("print the type of a service", _type_arguments, _type),
        "call": ("send a request and print the response", _call_arguments, _call),
    }
    add_live_subverbs(parser, subverbs, reach_of("servers"), ("call",))


def _list_arguments(parser: argparse.ArgumentParser) -> None:
    add_flag(parser, "--show-types", "also print the type of each service", short="-t")
    add_flag(parser, "--count-services", "print only the number of services", short="-c")
    hidden = "include services with a name part that begins with _, such as those of actions"
    add_flag(parser, "--include-hidden-services", hidden)


def _list(arguments: argparse.Namespace) -> int:
    """Print the services; return 0, also if there are none."""
    with Live(arguments) as live:
        types = types_by_name(live.graph().services)
        services = [name for name in types if arguments.include_hidden_services or not is_hidden(name)]
        lines = [name + (f" [{', '.join(types[name])}]" if arguments.show_types else "") for name in services]
        live.show_found("services", len(services), lines, counted=arguments.count_services)
    return 0


def _type_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "service", "SERVICE", "service, such as /get_map")


def _type(arguments: argparse.Namespace) -> int:
    """Print the types of the service, one per line; return 0.

    Raises:
        TransportError: the service has no server or client.
    """
    service = absolute(arguments.service)
    with Live(arguments) as live:
        types = types_by_name(live.graph(lambda graph: service in dict(graph.services)).services)
        if service not in types:
            raise live.unknown("service", service, types)
        show("\n".join(types[service]))
    return 0


def _call_arguments(parser: argparse.ArgumentParser) -> None:
    add_value(parser, "service", "SERVICE", "service, such as /light")
    add_value(parser, "type", "TYPE", "service type, such as std_srvs/srv/SetBool")
    add_message_arguments(parser, "values", "request", "{data: true}")
    rate = "repeat the call at this rate, Hz, until Ctrl-C (default: call once)"
    add_value(parser, "--rate", "HZ", rate, short="-r", type=positive)
    parser.epilog = "The exit code is 0 if the server responded, else 1."


def _call(arguments: argparse.Namespace) -> int:
    """Call the service once, or with `--rate` repeatedly until Ctrl-C; return 0 if the server has responded, else 1."""
    from graphengine.messages.message_input import full_type, parse
    from graphengine.messages.message_text import TypedValue, to_expression
    from graphengine.ros.service_caller import ServiceCaller

    service, service_type = absolute(arguments.service), full_type(arguments.type, "srv")
    responded = False
    with Live(arguments) as live:
        request_type, _ = live.definitions.service_parts(service_type)
        draft = parse(sys.stdin.read() if arguments.stdin else arguments.values, request_type, live.definitions)
        clock = live.clock(arguments)
        caller = ServiceCaller(live.transport, service, service_type, live.definitions)
        live.graph_now()  # starts the discovery of peers for `_why_no_server`
        if not caller.ready:
            show("waiting for service to become available...")
            live.wait_for_server(service, lambda: caller.ready, lambda: _why_no_server(live, service, service_type))
        due = time.monotonic()
        while True:
            request = draft.stamp(clock())
            show(f"requester: making request: {to_expression(TypedValue.of(request, live.definitions))}\n")
            response = caller.call(request).result()
            responded = True
            show(f"response:\n{to_expression(TypedValue.of(response, live.definitions))}\n")
            if arguments.rate is None:
                break
            due = max(due + 1.0 / arguments.rate, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
    return 0 if responded else 1


def _why_no_server(live: Live, service: str, service_type: str) -> str:
    """Return a likely reason why the service has no server of this type: another type, or a misspelt name.

    Return an empty text if no reason is known.
    """
    offered = types_by_name(pair for node in live.graph_now().nodes for pair in node.servers)
    if service in offered:
        found = sorted(set(offered[service]) - {service_type})
        return f"{service} has the type {' and '.join(found)}, not {service_type}" if found else ""
    hint = near_topic(service, offered)
    return f"{service} has no server yet; {hint}" if hint else ""
