"""Checks whether a stage can be read, and reports what USD cannot read in it; imports nothing of USD."""

from __future__ import annotations

import importlib.util
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import distributions
from pathlib import Path
from typing import Any

from graphengine.descriptions.usd.prim_spans import PrimSpans
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.distribution import install_command
from graphengine.format.files import Files
from graphengine.sandbox.untrusted import encoded

SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
PLACE = re.compile(r"/.*?:(?P<line>\d{1,9}):(?P<column>\d{1,9}): (?P<what>.*)", re.DOTALL)
"""Matches USD's messages about syntax errors: path, line, column and message."""
MOST_TOLD = 100
"""Maximum number of left-out parts that are reported one by one."""
LONGEST = 300
"""Maximum number of characters of a USD message that a finding quotes."""
_REMEDY = "the file may be damaged, or too large for the text format: save it as .usdc with USD's own tools"


@dataclass(frozen=True, slots=True)
class StageChoice:
    """What to read of a stage.

    Attributes:
        robot: path or name of the prim of the robot; empty if the stage contains only one.
        variants: variants to select, by SET or PRIM:SET.
        replaced: files in place of assets, by the reference to the asset.
        mirrors: folders with copies of assets on servers.
    """

    robot: str = ""
    variants: Mapping[str, str] = field(default_factory=dict)
    replaced: Mapping[str, str] = field(default_factory=dict)
    mirrors: Sequence[Path] = ()

    def keys(self) -> dict[str, Any]:
        """Return the keys of a robot file that say the same."""
        mirrors = [str(folder) for folder in self.mirrors]
        found = {"robot": self.robot, "variants": self.variants, "replace": self.replaced, "assets": mirrors}
        return {f"usd_{key}": value for key, value in found.items() if value}

    def request(self, path: Path, files: Files) -> bytes:
        """Return the request to a process that reads a stage."""
        choice = {
            "variants": dict(self.variants),
            "replaced": dict(self.replaced),
            "mirrors": [*map(str, self.mirrors)],
        }
        request = {"path": os.path.abspath(path), "roots": [*map(str, files.roots)], "choice": choice}
        return encoded(request).encode()


AS_IT_IS = StageChoice()
"""Read a stage as it is, with its only robot."""


def needed() -> str:
    """Return the reason why no stage can be read and the command that mends it; empty if USD's library is installed."""
    if importlib.util.find_spec("pxr") is not None:
        return ""
    return f"reading stages needs usd-core\n  {install_command('usd')}"


def tell_failure(failure: str, code: str, spans: PrimSpans, findings: Findings) -> None:
    """Report why USD cannot read a file; if USD's message begins with a line and column, the finding has this position."""
    found = PLACE.match(failure)
    if found is None or not spans.source.lines:
        findings.add(code, f"USD cannot read the stage: {failure[:LONGEST]}", spans.start, _REMEDY)
    else:
        place = Span(spans.source, int(found["line"]), int(found["column"]))
        findings.add(code, f"USD syntax error: {found['what'][:LONGEST]}", place)


def tell_process(error: Exception, code: str, spans: PrimSpans, findings: Findings) -> None:
    """Report that the process that reads a stage failed; a second distribution of USD's library is named as the likely cause."""
    rivals = [each.name for each in distributions(name="usd-exchange")]
    remedy = f"{rivals[0]} is installed, which replaces the library of usd-core: uninstall it" if rivals else _REMEDY
    findings.add(code, f"USD's reader {error}", spans.start, remedy)


def tell_left_out(left_out: Iterable[tuple[str, str]], spans: PrimSpans, findings: Findings, remedy: str = "") -> None:
    """Warn about each part of a stage that was left out; `remedy` says how to bring assets that are on a server."""
    parts = list(left_out)
    for what, why in parts[:MOST_TOLD]:
        place = spans.of_file(what) or spans.of(what.partition(".")[0])
        findings.add("W302", f"{what} is left out: {why}", place, remedy if "://" in what else "")
    if len(parts) > MOST_TOLD:
        findings.add("W302", f"{len(parts) - MOST_TOLD} more parts are left out", spans.start)
