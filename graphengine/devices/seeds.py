"""Keys of random numbers: who draws them and the session's seed decide, not who drew before."""

from __future__ import annotations

import hashlib


def key_of(seed: int, path: str) -> int:
    """The 128 bit key of the Philox generator that belongs to a prim.

    Args:
        seed: of the session.
        path: of the node or sensor that draws.
    """
    return int.from_bytes(hashlib.blake2b(f"{seed} {path}".encode(), digest_size=16).digest(), "little")
