"""The distribution of this package: the name, which differs from the name of the package, and commands that install it."""

from __future__ import annotations

from graphengine.format.version import __version__

NAME, PACKAGE = "graphrun", "graphengine"
"""Names of the distribution and of the imported package. The distribution `graphengine` on PyPI belongs to another project."""
ON_PYPI = False
"""Whether this project owns `NAME` on PyPI. If not, all instructions install from a checkout or a wheel."""


def install_command(extra: str) -> str:
    """Return the command that installs this distribution with an extra, if necessary with a comment on the folder."""
    return f"pip install '{NAME}[{extra}]'" if ON_PYPI else _in_checkout(f"pip install '.[{extra}]'")


def reinstall_command(*, editable: bool = False) -> str:
    """Return the command that installs this version again, without extras."""
    if ON_PYPI and not editable:
        return f"pip install {NAME}=={__version__}"
    return _in_checkout(f"pip install {'-e ' * editable}.")


def requirement(extra: str) -> str:
    """Return the line of a requirements.txt for this version with an extra; a comment with a command if PyPI lacks it."""
    if ON_PYPI:
        return f"{NAME}[{extra}]=={__version__}"
    wheel = f"{NAME}-{__version__}-py3-none-any.whl"
    return f"# pip install '/path/to/graphengine[{extra}]'    # a checkout of version {__version__}, or {wheel}"


def _in_checkout(command: str) -> str:
    return f"{command}    # in a checkout of graphengine"
