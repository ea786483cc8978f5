"""`graphrun topics`: list the topics, services and actions of a scene without running it."""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys

from graphengine.cli.common import add_file_arguments, clean, fitted_table, load, print_findings
from graphengine.messages.endpoints import EndpointClaim
from graphengine.messages.names import action_of

FRAMES = 2
"""Maximum number of transforms to print for one publisher; `--format json` prints all."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun topics` to its parser."""
    add_file_arguments(parser)
    form = "output format (default text); foxglove-layout is a layout that shows the scene's topics, for import in Foxglove"
    parser.add_argument("--format", choices=("text", "json", "foxglove-layout"), default="text", help=form)


def execute(arguments: argparse.Namespace) -> int:
    """Print the topics, services and actions; return 0, or 1 if the file has errors."""
    scene = load(arguments)
    if scene.findings.errors:
        print_findings(scene.findings, notes=False)
        return 1
    claims = sorted(scene.claims, key=lambda claim: (claim.topic, claim.direction, claim.node))
    if arguments.format == "json":
        print(json.dumps([dataclasses.asdict(claim) for claim in claims], indent=2))
        return 0
    if arguments.format == "foxglove-layout":
        from graphengine.ros.foxglove.foxglove_layout import foxglove_layout

        print(json.dumps(foxglove_layout(claims), indent=2))
        return 0
    rows: list[tuple[str, ...]] = [("TOPIC", "", "TYPE", "RATE", "QOS", "FRAME", "NODE")]
    # Of the services and topics of an action, one stands for all.
    rows += [_row(claim) for claim in claims if not action_of(claim.topic) or claim.topic.endswith("/send_goal")]
    print(clean(fitted_table([tuple(cell.replace("\n", " ") for cell in row) for row in rows], 4)))
    if scene.world is None:
        print("the namespaces of topics are unknown without a scene; give one with --scene", file=sys.stderr)
    return 0


def _row(claim: EndpointClaim) -> tuple[str, ...]:
    if action := action_of(claim.topic):
        arrow = "act" if claim.direction == "serve" else "goal"
        return action, arrow, claim.message_type.removesuffix("_SendGoal"), "", "", "", claim.node
    arrow = {"publish": "pub", "subscribe": "sub", "serve": "srv", "call": "call"}[claim.direction]
    if claim.direction != "publish":
        rate = ""
    elif claim.latched:
        rate = "once"
    else:
        rate = f"{claim.rate:g} Hz" if claim.rate else "on event"
    qos = claim.qos
    quality = f"{qos.reliability}, {qos.durability}, {qos.depth if qos.history == 'keepLast' else qos.history}"
    edges = [f"{parent} -> {child}" for parent, child in claim.transforms]
    more = [f"… ({len(edges) - FRAMES} more)"] if len(edges) > FRAMES else []
    frames = ", ".join([*edges[:FRAMES], *more]) or claim.frame_id
    return claim.topic, arrow, claim.message_type, rate, quality, frames, claim.node
