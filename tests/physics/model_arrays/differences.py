"""Compares arrays of two models, bit by bit or with a tolerance for rounding errors."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from tests.physics.model_arrays.figures import Array, owner

TOLERANCE = 1e-12
"""Largest difference, relative to the largest element of the array."""
SINGLE = 2e-7
"""The same for numbers that are rounded to single precision."""
MEASURED = 1e-6
"""The same for `actuator_lengthrange`, which MuJoCo measures in a simulation."""
OF_FRAMES = ("bvh_aabb", "body_sameframe", "geom_sameframe", "site_sameframe", "body_simple", "dof_simplenum")
"""Arrays that depend on which principal axes of an inertia come first; not compared where these differ."""


@dataclass(frozen=True)
class Difference:
    """An array that differs.

    Attributes:
        name: of the array.
        index: of the first element that differs; empty if no element can be named, for the reason `why`.
        old: stored element.
        new: element of the model.
        count: number of elements that differ.
        largest: largest absolute difference.
    """

    name: str
    index: tuple[int, ...] = ()
    old: float = 0.0
    new: float = 0.0
    count: int = 0
    largest: float = 0.0
    why: str = ""

    def told(self, model: mujoco.MjModel) -> str:
        """Return the difference as a line."""
        if not self.index:
            return f"{self.name}: {self.why}"
        whose = owner(model, self.name, self.index[0]) if "." not in self.name else ""
        place = f"{self.name}[{', '.join(map(str, self.index))}]" + (f" ({whose})" if whose else "")
        more = f"{self.count} of its elements differ, by up to {self.largest:.3g}"
        return f"{place}: stored {self.old!r}, now {self.new!r}; {more}"


def differences(
    before: Mapping[str, Array | None], now: Mapping[str, Array], changed: Collection[str], *, exact: bool
) -> list[Difference]:
    """Return the differences between the arrays of a stored model and of another one.

    Args:
        before: stored arrays in one dimension, by name; None for an array of which only the digest is stored.
        now: arrays of the model.
        changed: names of the arrays whose digests differ.
        exact: whether all bits must be equal. Otherwise, rounding errors are allowed, quaternions may have the other sign, and
            inertias are compared as tensors.
    """
    found = [each for name in changed if (each := _compared(name, before.get(name), now.get(name), exact=exact))]
    if exact or not {"body_inertia", "body_iquat"} & {each.name for each in found}:
        return found
    left_out = {"body_inertia", "body_iquat", *OF_FRAMES}
    old, new = _tensors(before), _tensors(now)
    tensors = _elements("inertia tensor of body", old, new, np.abs(old - new) > TOLERANCE * _scale(old))
    return [each for each in found if each.name not in left_out] + ([tensors] if tensors is not None else [])


def _compared(name: str, old: Array | None, new: Array | None, *, exact: bool) -> Difference | None:
    if new is None:
        return Difference(name, why="is missing")
    if old is None:
        return Difference(name, why="its digest differs, and its elements are not stored")
    if old.size != new.size or old.dtype != new.dtype:
        why = (
            f"{old.size} elements of type {old.dtype} are stored, now it has the shape {new.shape} of type {new.dtype}"
        )
        return Difference(name, why=why)
    old = old.reshape(new.shape)
    return _elements(name, old, new, _unequal_bits(old, new) if exact else _far(name, old, new))


def _elements(name: str, old: Array, new: Array, differing: Array) -> Difference | None:
    """Return the difference that an array of truth values marks; None if it marks nothing."""
    places = np.argwhere(differing)
    if not len(places):
        return None
    index = tuple(map(int, places[0]))
    distance = np.abs(old.astype(np.float64) - new.astype(np.float64))[differing]
    return Difference(
        name, index, old[index].item(), new[index].item(), len(places), float(np.nanmax(distance, initial=0.0))
    )


def _unequal_bits(old: Array, new: Array) -> Array:
    bits = f"u{old.itemsize}"
    unequal: Array = np.ascontiguousarray(old).view(bits) != np.ascontiguousarray(new).view(bits)
    return unequal


def _far(name: str, old: Array, new: Array) -> Array:
    """Return which elements differ by more than rounding errors."""
    if old.dtype.kind != "f":
        unequal: Array = old != new
        return unequal
    if name.endswith("quat") and old.shape[-1:] == (4,):
        new = np.where((old * new).sum(axis=-1, keepdims=True) < 0, -new, new)
    far: Array = ~(np.abs(old.astype(np.float64) - new.astype(np.float64)) <= _tolerance(name, old) * _scale(old)) & (
        old != new
    )
    return far


def _tolerance(name: str, array: Array) -> float:
    if name == "actuator_lengthrange":
        return MEASURED
    return SINGLE if array.itemsize == 4 or name.endswith("invweight0") else TOLERANCE


def _scale(array: Array) -> float:
    finite = np.abs(array[np.isfinite(array)].astype(np.float64))
    return float(max(finite.max(initial=0.0), 1e-3))


def _tensors(arrays: Mapping[str, Array | None]) -> Array:
    """Return the inertia tensors of all bodies, in the frames of the bodies; shape (number of bodies, 3, 3)."""
    moments, turns = arrays["body_inertia"], arrays["body_iquat"]
    assert moments is not None
    assert turns is not None
    found = np.zeros((moments.size // 3, 3, 3))
    for number, (moment, turn) in enumerate(zip(moments.reshape(-1, 3), turns.reshape(-1, 4), strict=True)):
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, turn)
        found[number] = (axes.reshape(3, 3) * moment) @ axes.reshape(3, 3).T
    return found
