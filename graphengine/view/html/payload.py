"""Packs JSON values and arrays into one compressed text, which the page's script unpacks."""

from __future__ import annotations

import base64
import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

_TYPES = {"f4": "Float32Array", "f8": "Float64Array", "u1": "Uint8Array", "u2": "Uint16Array", "u4": "Uint32Array"}


class Payload:
    """Collects arrays for one page."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0

    def put(self, array: NDArray[Any], *, steps: bool = False) -> dict[str, Any]:
        """Store a little-endian array, and return a reference, which stands for the array in the values of `text`.

        Numbers are split into planes of their first bytes, second bytes and so on, because similar bytes compress well.

        Args:
            array: numbers of 1 to 8 bytes.
            steps: whether to store the differences of successive 32-bit patterns, which compress better for smooth curves.
        """
        flat = np.ascontiguousarray(array).reshape(-1)
        stored = np.diff(flat.view(np.uint32), prepend=np.uint32(0)) if steps else flat
        self._parts.append(stored.view(np.uint8).reshape(-1, flat.itemsize).T.tobytes())
        at, self._size = self._size, self._size + flat.nbytes
        return {"array": _TYPES[flat.dtype.str[1:]], "at": at, "count": flat.size, "steps": steps}

    def text(self, values: Any) -> str:
        """Return JSON values and all stored arrays as a zlib stream in Base64, which contains no HTML syntax."""
        head = json.dumps(values, allow_nan=False).encode()
        return base64.b64encode(
            zlib.compress(b"".join([len(head).to_bytes(4, "little"), head, *self._parts]), 9)
        ).decode()
