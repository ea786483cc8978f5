"""Kinds of metadata that a lidar or radar of Isaac Sim has for each point, and the ports of nodes for them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from graphengine.node import In
from graphengine.node.types import POINTER, read_only

_DATA_TYPES: Mapping[str, dict[str, Any]] = {
    "azimuth": {"type": "float", "default": 4.0},
    "elevation": {"type": "float", "default": 4.0},
    "distance": {"type": "float", "default": 4.0},
    "intensity": {"type": "float"},
    "timestamp": {"type": "uint64"},
    "emitterId": {"type": "uint"},
    "channelId": {"type": "uint"},
    "materialId": {"type": "uint"},
    "tickId": {"type": "uint"},
    "hitNormal": {"type": "float[3]"},
    "velocity": {"type": "float[3]"},
    "objectId": {"type": "uint[]", "default": read_only(np.zeros(4, np.uint32))},
    "echoId": {"type": "uchar"},
    "tickState": {"type": "uchar"},
    "radialVelocityMS": {"type": "float"},
}
"""A dict from each kind of metadata to the type and default of the port that gives the type of the buffer's elements."""


def metadata_ports(
    port: Callable[..., Any], kinds: Mapping[str, tuple[str, str]], data_type: str = "", size: str = ""
) -> dict[str, Any]:
    """Return a dict from Python names to ports: for each kind of metadata, a buffer, the type of its elements and its size.

    Args:
        port: `In` or `Out`.
        kinds: a dict from each kind of metadata to the unit and description of its buffer.
        data_type: description of the ports for types.
        size: description of the ports for sizes.
    """
    ports: dict[str, Any] = {}
    for name, (unit, doc) in kinds.items():
        field = _field(name)
        ports[f"{field}_ptr"] = port(type=POINTER, default=0, name=f"{name}Ptr", unit=unit, doc=doc)
        ports[f"{field}_data_type"] = port(**_DATA_TYPES[name], name=f"{name}DataType", doc=data_type)
        ports[f"{field}_buffer_size"] = port(type="uint64", default=0, name=f"{name}BufferSize", doc=size)
    return ports


def output_inputs(names: Iterable[str], docs: Mapping[str, str] = MappingProxyType({})) -> dict[str, Any]:
    """Return a dict from Python names to the inputs that select kinds of metadata, such as `outputIntensity`.

    Args:
        names: kinds of metadata.
        docs: a dict from a kind of metadata to the description of its input.
    """
    return {
        f"output_{_field(name)}": In(type="bool", default=False, name=output_name(name), doc=docs.get(name, ""))
        for name in names
    }


def output_name(name: str) -> str:
    """Return the name of the input that selects a kind of metadata, such as `outputIntensity` for `intensity`."""
    return f"output{name[0].upper()}{name[1:]}"


def _field(name: str) -> str:
    """Return the Python name of a kind of metadata, such as `radial_velocity_ms` for `radialVelocityMS`."""
    return re.sub("(?<=[a-z])[A-Z]+", lambda found: f"_{found[0]}", name).lower()
