"""`graphrun service call`: send a request and print the response."""

from __future__ import annotations

import argparse
import sys
import time

from graphengine.cli.live import Live, absolute, add_live_arguments, near_topic, positive, show


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun service call` to its parser."""
    parser.add_argument("service", metavar="SERVICE", help="service, such as /light")
    parser.add_argument("type", metavar="TYPE", help="service type, such as std_srvs/srv/SetBool")
    source = parser.add_mutually_exclusive_group()
    values = "request as YAML, such as '{data: true}' (default '{}'); the values `auto` of a header and `now` of a time become"
    values += " the time of sending"
    source.add_argument("values", metavar="VALUES", nargs="?", default="{}", help=values)
    source.add_argument("--stdin", action="store_true", help="read the request from standard input")
    rate = "repeat the call at this rate, Hz, until Ctrl-C (default: call once)"
    parser.add_argument("-r", "--rate", metavar="HZ", type=positive, help=rate)
    parser.epilog = "The exit code is 0 if the server responded, else 1."
    add_live_arguments(parser, clock=True)


def execute(arguments: argparse.Namespace) -> int:
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
    """Return a likely reason why the service has no server of this type: its type differs, or the name is misspelt.

    The text is empty if no reason is known.
    """
    offered: dict[str, set[str]] = {}
    for node in live.graph_now().nodes:
        for name, kind in node.servers:
            offered.setdefault(name, set()).add(kind)
    if service in offered:
        found = sorted(offered[service] - {service_type})
        return f"{service} has the type {' and '.join(found)}, not {service_type}" if found else ""
    hint = near_topic(service, offered)
    return f"{service} has no server yet; {hint}" if hint else ""
