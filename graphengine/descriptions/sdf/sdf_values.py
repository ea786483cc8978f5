"""Reads texts, numbers and poses of SDF elements, and writes poses for MJCF."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator, Sequence

from graphengine.descriptions.files.xml import Element, numbers
from graphengine.devices.rotation import NOWHERE, Pose, Quaternion, from_rpy, relative
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.wording import listing, printable

INFINITE = 1e16
"""Limits in SDF whose absolute value is at least this number mean no limit."""
_FARTHEST = 1e9
"""Maximum absolute value of a coordinate (m) or angle of a pose."""
_FORMATS = ("euler_rpy", "quat_xyzw")


class SdfError(Exception):
    """A part of an SDF file that cannot be converted.

    Attributes:
        message: text of the error.
        span: source location of the error.
        help: lines with remedies; empty lines are ignored.
        reported: whether the error has been added to findings.
    """

    def __init__(self, message: str, span: Span, *help: str) -> None:
        super().__init__(message)
        self.message = message
        self.span = span
        self.help = help
        self.reported = False


@contextlib.contextmanager
def reported(findings: Findings, code: str = "S103") -> Iterator[None]:
    """Catch an SdfError that is raised in this context, and add the error to the findings unless it was reported before."""
    try:
        yield
    except SdfError as error:
        if not error.reported:
            findings.add(code, error.message, error.span, *error.help)
        error.reported = True


def find(element: Element | None, *path: str) -> Element | None:
    """Return the first element at a path of tags below an element; None if there is none."""
    for tag in path:
        element = element.first(tag) if element is not None else None
    return element


def text_at(element: Element | None, *path: str) -> str:
    """Return the text of the element at a path of tags; empty if there is no such element."""
    found = find(element, *path)
    return found.text if found is not None else ""


def flag_at(element: Element | None, *path: str) -> bool | None:
    """Return the boolean in the element at a path of tags; None without such an element or text."""
    text = text_at(element, *path).lower()
    return text in ("true", "1") if text else None


def numbers_at(element: Element | None, *path: str, default: Sequence[float]) -> tuple[float, ...]:
    """Return the numbers in the element at a path of tags; `default` without such an element or text.

    Raises:
        SdfError: the text does not consist of as many numbers as the default has.
    """
    found = find(element, *path)
    if found is None or not found.text:
        return tuple(default)
    values = numbers(found.text, len(default))
    if values is None or max(map(abs, values)) > INFINITE:
        count = "a number" if len(default) == 1 else f"{len(default)} numbers"
        raise SdfError(f"{found.tag} must be {count}, not {printable(found.text[:60])!r}", found.span)
    return values


def number_at(element: Element | None, *path: str, default: float) -> float:
    """Return the number in the element at a path of tags; `default` without such an element or text.

    Raises:
        SdfError: the text is not a number.
    """
    return numbers_at(element, *path, default=(default,))[0]


def limit_at(element: Element | None, *path: str, default: float) -> float:
    """Return the limit in the element at a path of tags, or `default`. Limits of at least `INFINITE` become infinite.

    Raises:
        SdfError: the text is not a number.
    """
    found = find(element, *path)
    try:
        value = float(found.text) if found is not None and found.text else default
    except ValueError:
        value = math.nan
    if math.isnan(value):
        assert found is not None
        raise SdfError(f"{found.tag} must be a number, not {printable(found.text[:60])!r}", found.span)
    return math.copysign(math.inf, value) if abs(value) >= INFINITE else value


def pose_of(pose: Element | None) -> Pose:
    """Return the pose (position in m, quaternion) in a `<pose>` element; the identity without an element or text.

    Raises:
        SdfError: the pose has the wrong number of values, values out of range, or an unknown rotation format.
    """
    if pose is None or not pose.text:
        return NOWHERE
    kind = pose.get("rotation_format") or "euler_rpy"
    if kind not in _FORMATS:
        raise SdfError(f"unknown rotation_format {printable(kind[:40])!r}", pose.span, listing(_FORMATS))
    count = 7 if kind == "quat_xyzw" else 6
    values = numbers(pose.text, count)
    if values is None or max(map(abs, values)) > _FARTHEST:
        raise SdfError(f"pose must be {count} numbers in m and rad, not {printable(pose.text[:80])!r}", pose.span)
    x, y, z, *rotation = values
    if count == 7:
        return (x, y, z), _unit(rotation, pose.span)
    scale = math.radians(1.0) if flag(pose.get("degrees")) else 1.0
    roll, pitch, yaw = (angle * scale for angle in rotation)
    return (x, y, z), from_rpy(roll, pitch, yaw)


def flag(text: str) -> bool:
    """Return whether the text of a boolean attribute is `true` or `1`."""
    return text.strip().lower() in ("true", "1")


def _unit(values: Sequence[float], span: Span) -> Quaternion:
    x, y, z, w = values
    length = math.hypot(x, y, z, w)
    if not length:
        raise SdfError("the quaternion of a pose must not be zero", span)
    return x / length, y / length, z / length, w / length


def seen_from(frame: Pose, place: Pose) -> Pose:
    """Return the pose `place` relative to the pose `frame`; both are given in the same frame. -0.0 becomes 0.0."""
    (x, y, z), (qx, qy, qz, qw) = relative(frame, place)
    return (x + 0.0, y + 0.0, z + 0.0), (qx + 0.0, qy + 0.0, qz + 0.0, qw + 0.0)


def leaf(tag: str, text: str, span: Span) -> Element:
    """Return an element that has only a text: no attributes and no children."""
    return Element(tag, {}, span, [], text)
