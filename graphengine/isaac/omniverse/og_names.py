"""Parses paths, attributes, types and pipeline stages in calls of OmniGraph."""

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
    """A call that OmniGraph would also refuse; the script may catch the error."""


class NotThereError(OmniGraphError):
    """A call refers to a graph or node that the script did not create; a USD file that the script opens may contain it."""


def checked(name: Any, what: str) -> str:
    """Return a name, path or type from a script unchanged if it is valid.

    Raises:
        OmniGraphError: it is not valid.
    """
    if not isinstance(name, str) or not name.strip("/") or len(name) > MAX_NAME or not name.isprintable():
        raise OmniGraphError(f"expected {what}, got {shown(name)}")
    return str(name)


def absolute(path: str) -> str:
    """Return a prim path with a leading slash and without a trailing one."""
    return "/" + checked(path, "the path of a prim").strip("/")


def split_attribute(path: str) -> tuple[str, str]:
    """Return node and name of `Node.inputs:x`, which old scripts write as `Node/inputs:x`."""
    node, dot, name = path.rpartition(".")
    if not dot:
        node, _, name = path.rpartition("/")
        name = name if name.startswith(SIDES) else ""
    if not node or not name:
        raise OmniGraphError(f"{path!r} is not an attribute; write 'Node.inputs:x'")
    return node, name


def full_name(name: str) -> str:
    """Return the full name of an attribute; the prim name of an output bundle, `outputs_x`, becomes `outputs:x`."""
    return f"outputs:{name[8:]}" if name.startswith("outputs_") else name


def type_name(type: Any) -> str:
    """Return the OmniGraph name of a type, such as `double[3]`, or of a list of alternatives, such as `int|double`.

    Raises:
        OmniGraphError: it is not a type.
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
    """Return the pipeline stage for an enumerator or a USD token.

    Raises:
        OmniGraphError: there is no such stage.
    """
    stage = pipeline_stage(str(getattr(value, "name", value)))
    if stage is None:
        raise OmniGraphError(f"no pipeline stage {shown(value)}; {listing(PIPELINE_STAGES)}")
    return stage


def items(commands: Any) -> Iterable[Any]:
    """Return the items of one key of an edit as a list; a single item may be given without a list."""
    several = isinstance(commands, tuple) and commands and isinstance(commands[0], tuple | list)
    return list(commands) if several or isinstance(commands, list) else [commands]
