"""Reads which joints the controllers in the graphs of a stage command, and how; runs in the confined process."""

from __future__ import annotations

from collections.abc import Iterable

from pxr import Usd

from graphengine.descriptions.usd.stage_frames import given, target, text
from graphengine.descriptions.usd_model import StageCommand

_CONTROLLER = "IsaacArticulationController"
_KINDS = ("position", "velocity", "effort")
_MOST_INPUTS = 1000
"""Maximum number of joint names that are collected from the nodes of an array."""


def read_command(prim: Usd.Prim) -> StageCommand | None:
    """Return the commands of an ArticulationController; None for another prim, and for one that commands nothing.

    A command counts if it is wired or has a value. The names of the joints may come from constants, or from a node that makes an
    array of constants; names from elsewhere, such as a topic, are unknown.
    """
    if text(prim, "node:type").rpartition(".")[2] != _CONTROLLER:
        return None
    kinds = [kind for kind in _KINDS if _is_set(prim, f"inputs:{kind}Command")]
    if not kinds:
        return None
    aim = target(prim, "inputs:targetPrim") or text(prim, "inputs:robotPath")
    return StageCommand(str(prim.GetPath()), aim, kinds, list(_names(prim, "inputs:jointNames")))


def _is_set(prim: Usd.Prim, name: str) -> bool:
    attribute = prim.GetAttribute(name)
    if not attribute:
        return False
    value = attribute.Get()
    return bool(attribute.GetConnections()) or (hasattr(value, "__len__") and len(value) > 0)


def _names(prim: Usd.Prim, name: str, depth: int = 3) -> Iterable[str]:
    """Return the joint names that an input has, following its wire to a node with constants."""
    attribute = prim.GetAttribute(name)
    for source in attribute.GetConnections() if attribute and depth else ():
        node = prim.GetStage().GetPrimAtPath(source.GetPrimPath())
        inputs = (
            [each.GetName() for each in node.GetAttributes() if each.GetName().startswith("inputs:")] if node else []
        )
        numbered = sorted((each for each in inputs if each[7:].startswith("input") and each[12:].isdigit()), key=len)
        wanted = numbered[:_MOST_INPUTS] or [each for each in inputs if each == "inputs:value"]
        return [found for each in wanted for found in _names(node, each, depth - 1)]
    value = given(prim, name)
    return [value] if isinstance(value, str) else [str(each) for each in value or () if isinstance(each, str)]
