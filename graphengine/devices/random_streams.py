"""Keys of random generators, one for each prim, so that no prim's random numbers depend on what other prims draw."""

from __future__ import annotations

import hashlib


def key_of(seed: int, path: str) -> int:
    """Return the 128-bit key of a prim's Philox generator.

    Args:
        seed: seed of the session.
        path: prim path of the node or sensor that draws.
    """
    return int.from_bytes(hashlib.blake2b(f"{seed} {path}".encode(), digest_size=16).digest(), "little")
