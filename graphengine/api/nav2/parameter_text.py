"""Writes ROS parameters as YAML, each with a comment that names the source of its value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import yaml

from graphengine.api.nav2.sourced import Sourced
from graphengine.format.yaml_text import comment

Parameters = Mapping[str, "Sourced[Any] | Parameters"]
"""Parameters by name; the parameters of a plugin are a nested mapping."""


def node(parameters: Parameters) -> Parameters:
    """Return the parameters of a node below `ros__parameters`, with `use_sim_time` added."""
    return {"ros__parameters": {"use_sim_time": Sourced(True, "the simulation publishes /clock"), **parameters}}


def parameter_text(nodes: Parameters, namespace: str, head: str) -> str:
    """Return the content of a parameter file.

    Args:
        nodes: parameters of each node, as `node` returns them.
        namespace: namespace of the nodes; empty for none.
        head: first line, written as a comment.
    """
    for name in reversed(list(filter(None, namespace.split("/")))):
        nodes = {name: nodes}
    return "\n".join([comment(head), *_lines(nodes, "")]) + "\n"


def _lines(tree: Parameters, indent: str) -> Iterator[str]:
    for name, value in tree.items():
        if isinstance(value, Sourced):
            yield f"{indent}{name}: {_scalar(value.value)}  {comment(value.source)}"
        else:
            yield f"{indent}{name}:"
            yield from _lines(value, f"{indent}  ")


def _scalar(value: Any) -> str:
    """Return a value as YAML on one line; a float always has a decimal point, because ROS takes its type from it."""
    if isinstance(value, float):
        value = float(f"{value:.6g}") + 0.0  # without the sign of zero
    elif isinstance(value, list | tuple):
        return f"[{', '.join(map(_scalar, value))}]"
    text = yaml.safe_dump(value, default_flow_style=True, width=10**9)
    return text.removesuffix("\n").removesuffix("\n...")
