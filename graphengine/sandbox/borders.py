"""The kernel features that confine processes, and the policy for machines without these features."""

from __future__ import annotations

from graphengine.format.diagnostics import Findings, Span
from graphengine.sandbox import landlock, seccomp

BORDERS = {
    "Landlock": (landlock.available, "its code may read all files that you may read"),
    "seccomp": (seccomp.available, "its code may write files, start programs and use the network"),
}
"""For each kernel feature: a function that returns whether this kernel has the feature, and the danger without the feature."""
TRUST = "--trust runs the code of this file with all your permissions: read the file first"


def missing() -> list[str]:
    """Return the names of the kernel features that this machine lacks."""
    return [name for name, (available, _) in BORDERS.items() if not available()]


def admit(what: str, findings: Findings, span: Span, *, trusted: bool) -> bool:
    """Return whether a script or stage may be read: either it can be fully confined, or the user trusts it.

    If a kernel feature is missing, `findings` receives a warning for a trusted file and an error otherwise.
    """
    lacking = missing()
    if lacking and trusted:
        text = f"{what} is trusted and read without confinement by {' and '.join(lacking)}"
        findings.add("W206", text, span, *_dangers(lacking))
    elif lacking:
        text = f"{what} is not read: this machine has no {' and no '.join(lacking)}"
        findings.add("G401", text, span, *_dangers(lacking), TRUST)
    return trusted or not lacking


def warn(findings: Findings) -> None:
    """Warn if descriptions and meshes are read without full confinement, because this machine lacks a kernel feature."""
    if lacking := missing():
        borders = " and ".join(lacking)
        text = f"descriptions and meshes are read without confinement by {borders}, which this machine lacks"
        findings.add("W206", text, None, *_dangers(lacking))


def describe() -> str:
    """Return a line such as `Landlock: yes, seccomp: no` about the kernel features of this machine."""
    return ", ".join(f"{name}: {'yes' if available() else 'no'}" for name, (available, _) in BORDERS.items())


def _dangers(names: list[str]) -> list[str]:
    return [f"without {name}, {BORDERS[name][1]} if it gets past Python's checks" for name in names]
