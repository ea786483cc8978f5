"""Converts and compares names and paths of prims, as text."""

from __future__ import annotations

import re

from graphengine.format.errors import PrimError


def prim_name(name: str) -> str:
    """Return a name that is legal in USD: `_` replaces illegal characters and precedes a leading digit."""
    plain = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{plain}" if plain[:1].isdigit() else plain


def normalize(path: str) -> str:
    """Return an absolute path without doubled or trailing slashes.

    Raises:
        PrimError: the path is not absolute, or one of its elements is `.` or `..`.
    """
    what = f"{path!r} is not a prim path"
    if not path.startswith("/"):
        raise PrimError(what, path, "a prim path begins with '/', as in /dd100/Geometry/base_link")
    parts = [part for part in path.split("/") if part]
    if any(part in (".", "..") for part in parts):
        raise PrimError(what, path, "write the path without '.' and '..'")
    return "/" + "/".join(parts)


def at_or_below(path: str, other: str) -> bool:
    """Return whether `path` equals `other` or lies below it. Both paths must be normalized and complete."""
    return path == other or path.startswith(f"{other}/")
