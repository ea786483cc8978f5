"""Report on an imported robot: its properties, and the converted, guessed and omitted values, with file and line."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphengine.cli.common import counted
from graphengine.format.diagnostics import Finding, Findings, Span
from graphengine.format.files import near
from graphengine.format.wording import listing, quoted

if TYPE_CHECKING:
    from graphengine.bringup.robots.import_robot import Imported

LONGEST = 12
"""Maximum number of lines for remarks of one kind; the robot file has all remarks."""
WIDEST = 160
"""Maximum number of characters to print of a remark."""


def report(imported: Imported, findings: Findings) -> list[str]:
    """Return the lines of the report on an imported robot."""
    robot, description = imported.robot, imported.robot.description
    draft = imported.draft
    base = "free" if imported.free else "fixed to the world"
    if imported.free and not draft.wheels:
        base += "; --fixed-base fixes it to the world"
    links, joints = counted(len(description.links), "link"), counted(len(description.joints), "joint")
    lines = [f"wrote {', '.join(near(str(path)) for path in imported.files)}"]
    lines += [f"{links}, {joints} of which {len(robot.moving)} move, {description.mass:.4g} kg"]
    lines += [f"base link {description.root}, {base}"]
    if imported.lowest is not None:
        pose = "all joints at zero" if robot.keyframe is None else f"joints as in keyframe {robot.spec.start}"
        lines.append(f"lowest collider at z = {imported.lowest:.4f} m, {pose}")
    outcomes = Counter(imported.library.outcomes.values())
    lines.append(f"meshes: {', '.join(f'{number} {what}' for what, number in sorted(outcomes.items())) or 'none'}")
    if followers := [joint.name for joint in robot.moving if joint.mimic is not None]:
        lines.append(listing(followers, "joints that follow another joint"))
    written = {str(path) for path in imported.files}  # notes on these files repeat the remarks
    notes = [note for note in findings.items if note.severity == "note" and not _lies_in(note, written)]
    lines += _some("note", [(": ".join([note.message, *note.help]), _place(note.span, column=True)) for note in notes])
    known = {"carried over": draft.carried, "noticed": draft.noticed}
    unknown = {"guessed": draft.guessed, "not carried over": draft.lost}
    for what, remarks in (known | unknown).items():
        lines += _some(what, [(remark.text, _place(remark.span)) for remark in remarks])
    if imported.outside:
        allowed = " ".join(f"--allow {quoted(near(str(folder)))}" for folder in imported.outside)
        lines.append(f"scenes with this robot read files outside of their folder: run them with {allowed}")
    return [line.replace("\n", " ") for line in lines]


def example(imported: Imported) -> str:
    """Return a line for the user with an entry of `robots` in a scene file, which places the robot on the floor."""
    height = imported.lift or imported.rise
    place = f", position: [0, 0, {height:g}]" if height else ""
    return f"in a scene: robots: {{{imported.robot.name}: {{use: {imported.use}{place}}}}}"


def _lies_in(finding: Finding, paths: Collection[str]) -> bool:
    return finding.span is not None and finding.span.source.path in paths


def _place(span: Span | None, *, column: bool = False) -> str:
    """Return the file, the line and, with `column`, the column of a span, in brackets; empty without a span."""
    if span is None:
        return ""
    return f" ({Path(span.source.path).name}:{span.line}{f':{span.column}' if column else ''})"


def _some(what: str, items: Sequence[tuple[str, str]]) -> list[str]:
    """Return a line for each of the first `LONGEST` items, and a line with the number of further items.

    Args:
        what: label before each item.
        items: text and source location of each item; texts are cut to `WIDEST` characters.
    """
    cut = [(text if len(text) <= WIDEST else f"{text[: WIDEST - 1]}…", place) for text, place in items[:LONGEST]]
    shown = [f"{what}: {text}{place}" for text, place in cut]
    return [*shown, *([f"{what}: … ({len(items) - LONGEST} more)"] if len(items) > LONGEST else [])]
