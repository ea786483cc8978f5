"""Reads all public arrays and numbers of a model, and names the element that an index of an array belongs to."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
_OWNERS = {
    "body": ("nbody", mujoco.mjtObj.mjOBJ_BODY),
    "jnt": ("njnt", mujoco.mjtObj.mjOBJ_JOINT),
    "geom": ("ngeom", mujoco.mjtObj.mjOBJ_GEOM),
    "site": ("nsite", mujoco.mjtObj.mjOBJ_SITE),
    "cam": ("ncam", mujoco.mjtObj.mjOBJ_CAMERA),
    "mesh": ("nmesh", mujoco.mjtObj.mjOBJ_MESH),
    "mat": ("nmat", mujoco.mjtObj.mjOBJ_MATERIAL),
    "eq": ("neq", mujoco.mjtObj.mjOBJ_EQUALITY),
    "actuator": ("nu", mujoco.mjtObj.mjOBJ_ACTUATOR),
    "sensor": ("nsensor", mujoco.mjtObj.mjOBJ_SENSOR),
}
"""Number of elements and kind of object by the prefix of an array."""


def figures(model: mujoco.MjModel) -> dict[str, Array]:
    """Return copies of all arrays, numbers and texts of a model by name, those of its structures as `opt.timestep`."""
    return {name: np.array(_as_array(value)) for name, value in _attributes(model, "")}


def _attributes(structure: object, prefix: str) -> Iterator[tuple[str, Any]]:
    for name in sorted(dir(structure)):
        value = getattr(structure, name) if not name.startswith("_") else None
        if value is None or callable(value):
            continue
        if isinstance(value, bytes | bool | int | float | np.ndarray):
            yield prefix + name, value
        else:
            yield from _attributes(value, f"{prefix}{name}.")


def _as_array(value: bytes | float | Array) -> Array:
    """Return a value as an array; whole numbers of 64 bits keep their bits."""
    if isinstance(value, bytes):
        return np.frombuffer(value, np.uint8)
    if isinstance(value, np.ndarray):
        return value
    return np.array([value]) if isinstance(value, float) else np.array([value % 2**64], np.uint64).view(np.int64)


def digest(array: Array) -> str:
    """Return 16 hexadecimal digits of a hash of an array's type, shape and bytes."""
    head = f"{array.dtype.str} {array.shape} ".encode()
    return hashlib.sha256(head + np.ascontiguousarray(array).tobytes()).hexdigest()[:16]


def digests(arrays: Mapping[str, Array]) -> dict[str, str]:
    """Return the digest of each array by name."""
    return {name: digest(array) for name, array in arrays.items()}


def owner(model: mujoco.MjModel, name: str, row: int) -> str:
    """Return the kind and name of the element to which a row of an array belongs; empty if the array has no such elements."""
    prefix = name.partition("_")[0]
    if prefix == "dof" and getattr(model, name).shape[:1] == (model.nv,):
        prefix, row = "jnt", int(model.dof_jntid[row])
    elif prefix not in _OWNERS or getattr(model, name).shape[:1] != (getattr(model, _OWNERS[prefix][0]),):
        return ""
    name = mujoco.mj_id2name(model, _OWNERS[prefix][1], row)
    return f"{prefix} {name or row}"
