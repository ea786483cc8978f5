"""Reads texts, numbers and poses of SDF elements, and writes poses as URDF does."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence

from graphengine.devices.rotation import NOWHERE, Pose, Quaternion, Vector3, from_rpy, rotate
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing, printable
from graphengine.physics.files.xml import Element, numbers

INFINITE = 1e16
"""In SDF, limits of at least this number mean no limit."""
_FARTHEST = 1e9
"""Greatest coordinate (m) and angle (rad) of a pose."""
_FORMATS = ("euler_rpy", "quat_xyzw")


class SdfError(Exception):
    """A part of an SDF file that cannot be converted.

    Attributes:
        message: the error.
        span: its location.
        help: lines of help.
        reported: whether the error is in the findings already.
    """

    def __init__(self, message: str, span: Span, *help: str) -> None:
        super().__init__(message)
        self.message = message
        self.span = span
        self.help = help
        self.reported = False


@contextlib.contextmanager
def reported(findings: Findings, code: str = "S103") -> Iterator[None]:
    """Add an SdfError that is raised in the context to the findings, once."""
    try:
        yield
    except SdfError as error:
        if not error.reported:
            findings.add(code, error.message, error.span, *error.help)
        error.reported = True


def find(element: Element | None, *path: str) -> Element | None:
    """Return the first element at a path of tags; None if there is none."""
    for tag in path:
        element = element.first(tag) if element is not None else None
    return element


def text_at(element: Element | None, *path: str) -> str:
    """Return the text at a path; empty if there is none."""
    found = find(element, *path)
    return found.text if found is not None else ""


def flag_at(element: Element | None, *path: str) -> bool | None:
    """Return the boolean at a path; None if there is none."""
    text = text_at(element, *path).lower()
    return text in ("true", "1") if text else None


def numbers_at(element: Element | None, *path: str, default: Sequence[float]) -> tuple[float, ...]:
    """Return the numbers at a path, as many as the default has.

    Raises:
        SdfError: there is something else.
    """
    found = find(element, *path)
    if found is None or not found.text:
        return tuple(default)
    values = numbers(found.text, len(default))
    if values is None or max(map(abs, values)) > INFINITE:
        count = "a number" if len(default) == 1 else f"{len(default)} numbers"
        raise SdfError(f"{found.tag} is {count}, not {printable(found.text[:60])!r}", found.span)
    return values


def number_at(element: Element | None, *path: str, default: float) -> float:
    """Return the number at a path.

    Raises:
        SdfError: there is something else.
    """
    return numbers_at(element, *path, default=(default,))[0]


def limit_at(element: Element | None, *path: str, default: float) -> float:
    """Return a number at a path that may be infinite, or as large as SDF takes for infinite.

    Raises:
        SdfError: there is something else.
    """
    found = find(element, *path)
    try:
        value = float(found.text) if found is not None and found.text else default
    except ValueError:
        value = math.nan
    if math.isnan(value):
        assert found is not None
        raise SdfError(f"{found.tag} is a number, not {printable(found.text[:60])!r}", found.span)
    return math.copysign(math.inf, value) if abs(value) >= INFINITE else value


def pose_of(pose: Element | None) -> Pose:
    """Return the pose in a `<pose>` element, m and rad; without an element, the identity.

    Raises:
        SdfError: it has another number of values, or another format of rotations.
    """
    if pose is None or not pose.text:
        return NOWHERE
    kind = pose.get("rotation_format") or "euler_rpy"
    if kind not in _FORMATS:
        raise SdfError(f"unknown rotation_format {printable(kind[:40])!r}", pose.span, listing(_FORMATS))
    count = 7 if kind == "quat_xyzw" else 6
    values = numbers(pose.text, count)
    if values is None or max(map(abs, values)) > _FARTHEST:
        raise SdfError(f"pose is {count} numbers of m and rad, not {printable(pose.text[:80])!r}", pose.span)
    x, y, z, *rotation = values
    if count == 7:
        return (x, y, z), _unit(rotation, pose.span)
    scale = math.radians(1.0) if flag(pose.get("degrees")) else 1.0
    roll, pitch, yaw = (angle * scale for angle in rotation)
    return (x, y, z), from_rpy(roll, pitch, yaw)


def flag(text: str) -> bool:
    """Return the value of a boolean attribute."""
    return text.strip().lower() in ("true", "1")


def _unit(values: Sequence[float], span: Span) -> Quaternion:
    x, y, z, w = values
    length = math.hypot(x, y, z, w)
    if not length:
        raise SdfError("a quaternion of zeros is no rotation", span)
    return x / length, y / length, z / length, w / length


def written(*values: float) -> str:
    """Return numbers as text that gives the same numbers when read; -0.0 is written as 0.0."""
    return " ".join(repr(value + 0.0) for value in values)


def to_rpy(rotation: Quaternion) -> Vector3:
    """Return the angles (rad) about the fixed x axis, then y, then z; at a pitch of 90 degrees too."""
    ahead, left, up = (rotate(rotation, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    yaw = math.atan2(ahead[1], ahead[0])
    sine, cosine = math.sin(yaw), math.cos(yaw)
    pitch = math.atan2(-ahead[2], cosine * ahead[0] + sine * ahead[1])
    roll = math.atan2(sine * up[0] - cosine * up[1], cosine * left[1] - sine * left[0])
    return roll, pitch, yaw


def placed(pose: Pose, **more: str) -> dict[str, str]:
    """Return a pose as attributes of MJCF, after others."""
    x, y, z, w = pose[1]
    return {**more, "pos": written(*pose[0]), "quat": written(w, x, y, z)}


def origin(pose: Pose, span: Span) -> list[Element]:
    """Return a list with URDF's `<origin>` element of a pose; empty for the identity."""
    if pose == NOWHERE:
        return []
    return [Element("origin", {"xyz": written(*pose[0]), "rpy": written(*to_rpy(pose[1]))}, span)]


def leaf(tag: str, text: str, span: Span) -> Element:
    """Return an element that has a text only."""
    return Element(tag, {}, span, [], text)
