"""`graphrun schema`: print the JSON Schema of graph, scene or robot files, for editors."""

from __future__ import annotations

import argparse
import json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command-line arguments of `graphrun schema` to its parser."""
    parser.add_argument("kind", choices=("graph", "scene", "robot"), help="kind of file that the schema describes")


def execute(arguments: argparse.Namespace) -> int:
    """Print the schema; return 0."""
    from graphengine.compiler.registry import default_registry
    from graphengine.compiler.schema import make_schema

    print(json.dumps(make_schema(arguments.kind, default_registry()), indent=2))
    return 0
