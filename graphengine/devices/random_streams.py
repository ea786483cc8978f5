"""Derives the key of each prim's own random generator. The random numbers of one prim do not depend on those of other prims."""

from __future__ import annotations

import hashlib


def key_of(seed: int, path: str) -> int:
    """Return the 128-bit key of a prim's Philox generator.

    Args:
        seed: seed of the session.
        path: prim path of the node or sensor that uses the generator.
    """
    return int.from_bytes(hashlib.blake2b(f"{seed} {path}".encode(), digest_size=16).digest(), "little")
