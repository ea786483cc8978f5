"""The distribution of this package: its name, which is not that of the import, and the command that installs it."""

from __future__ import annotations

NAME = "graphrun"
ON_PYPI = False
"""Whether this project owns `NAME` on PyPI. Until then, every instruction installs from a checkout or a wheel."""


def install_command(extra: str) -> str:
    """Return the command that installs this distribution with an extra; a comment says where, if not everywhere."""
    return (
        f"pip install '{NAME}[{extra}]'" if ON_PYPI else f"pip install '.[{extra}]'    # in a checkout of graphengine"
    )
