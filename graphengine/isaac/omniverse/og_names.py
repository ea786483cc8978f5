"""Parses the paths, attribute names, types and pipeline stages that scripts pass to OmniGraph."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from graphengine.format.wording import listing, shown
from graphengine.isaac.omniverse.plain_data import is_unknown, plain_data
from graphengine.isaac.recorded_graph import PIPELINE_STAGES, PipelineStage, pipeline_stage

MAX_NAME = 1000
"""Maximum length of a name or path, characters."""
SIDES = ("inputs:", "outputs:", "state:")


class OmniGraphError(Exception):
    """An error that OmniGraph would also raise for the call; the script may catch it."""


class NotThereError(OmniGraphError):
    """The script refers to a graph or node that it did not create; a USD file may contain this graph or node."""


def checked(name: Any, what: str) -> str:
    """Return a name, path or type from a script as a string; `what` describes it in the error message.

    Raises:
        OmniGraphError: it is not a string, empty, longer than `MAX_NAME`, or has unprintable characters.
    """
    if not isinstance(name, str) or not name.strip("/") or len(name) > MAX_NAME or not name.isprintable():
        raise OmniGraphError(f"expected {what}, got {shown(name)}")
    return str(name)


def absolute(path: str) -> str:
    """Return a prim path with a leading slash and no trailing slash; raise OmniGraphError if it is not valid."""
    return "/" + checked(path, "the path of a prim").strip("/")


def split_attribute(path: str) -> tuple[str, str]:
    """Return the node and the attribute name in `Node.inputs:x`, or in the old spelling `Node/inputs:x`."""
    node, dot, name = path.rpartition(".")
    if not dot:
        node, _, name = path.rpartition("/")
        name = name if name.startswith(SIDES) else ""
    if not node or not name:
        raise OmniGraphError(f"{path!r} is not an attribute; write 'Node.inputs:x'")
    return node, name


def full_name(name: str) -> str:
    """Return the full name of an attribute: `outputs:x` for `outputs_x`, the prim of an output bundle; others are unchanged."""
    return f"outputs:{name[8:]}" if name.startswith("outputs_") else name


def type_name(type: Any) -> str:
    """Return the OmniGraph name of a type, such as `double[3]`; a list of types becomes a union such as `int|double`.

    Raises:
        OmniGraphError: the argument is not a type.
        UnknownError: only Omniverse knows the type.
    """
    if isinstance(type, str) or is_unknown(type):
        return str(plain_data(type))
    if isinstance(type, tuple) and type:
        return type_name(type[0])
    if isinstance(type, list):
        return "|".join(type_name(one) for one in type)
    named: Any = getattr(type, "get_ogn_type_name", None)
    if named is None:
        raise OmniGraphError(f"expected the name of a type, got {shown(type)}")
    return str(named())


def stage_of(value: Any) -> PipelineStage:
    """Return the pipeline stage for a member of `GraphPipelineStage` or a USD token.

    Raises:
        OmniGraphError: the pipeline stage does not exist.
    """
    stage = pipeline_stage(str(getattr(value, "name", value)))
    if stage is None:
        raise OmniGraphError(f"no pipeline stage {shown(value)}; {listing(PIPELINE_STAGES)}")
    return stage


def items(commands: Any) -> Iterable[Any]:
    """Return the items of one key of the edit commands as a list; scripts may write a single item without a list.

    An attribute such as `("inputs:x", node)` at the beginning of a tuple belongs to a single item.
    """
    if isinstance(commands, list):
        return list(commands)
    first = commands[0] if isinstance(commands, tuple) and commands else ""
    several = isinstance(first, tuple | list) and first and not str(first[0]).startswith(SIDES)
    return list(commands) if several else [commands]
