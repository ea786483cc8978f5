"""The types and values of ports as users read them, in messages, tables and drawings."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphengine.node.types import PortType, UnionType


def brief(port_type: PortType | UnionType) -> str:
    """Return the name of a type for error messages: of a union of more than 24 types, eight and the number of the others."""
    if isinstance(port_type, UnionType) and len(port_type.alternatives) > 24:
        first, others = port_type.alternatives[:8], port_type.alternatives[8:]
        return f"{UnionType(first)} | … ({len(others)} more: `graphrun nodes --format json`)"
    return str(port_type)


def with_article(port_type: PortType | UnionType) -> str:
    """Return the name of a type with its indefinite article, such as `a double` or `an int`."""
    name = brief(port_type)
    return f"{'an' if name[0] in 'aeio' else 'a'} {name}"


def listed(value: Any) -> Any:
    """Return a port value with its arrays as lists, to print it.

    A number of less than double precision becomes the shortest decimal that reads back as the same number: the float 0.45 is
    0.45, not 0.44999998807907104.
    """
    if not isinstance(value, np.ndarray | np.generic):
        return value
    short = value.dtype.kind == "f" and value.dtype.itemsize < np.dtype(np.float64).itemsize
    return (value.astype(str).astype(np.float64) if short else value).tolist()
