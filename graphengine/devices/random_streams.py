"""Keys of random generators, from the session's seed and a prim path; the order of draws has no influence."""

from __future__ import annotations

import hashlib


def key_of(seed: int, path: str) -> int:
    """Return the 128-bit key of a prim's Philox generator.

    Args:
        seed: seed of the session.
        path: prim path of the node or sensor that draws.
    """
    return int.from_bytes(hashlib.blake2b(f"{seed} {path}".encode(), digest_size=16).digest(), "little")
