"""The outcomes of goals sent to Nav2, as a table and as JUnit XML."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from graphengine.bringup.navigation.goal_list import NavigationGoal
from graphengine.format.atomic_write import write_together

REACHED = "reached"
RESET = "reset"
"""Result of a goal during which a reset of the run restarted simulation time and poses."""

_ERRORS = {
    ("controller", 100): "UNKNOWN INVALID_CONTROLLER TF_ERROR INVALID_PATH PATIENCE_EXCEEDED FAILED_TO_MAKE_PROGRESS"
    " NO_VALID_CONTROL CONTROLLER_TIMED_OUT",
    ("planner", 200): "UNKNOWN INVALID_PLANNER TF_ERROR START_OUTSIDE_MAP GOAL_OUTSIDE_MAP START_OCCUPIED GOAL_OCCUPIED"
    " TIMEOUT NO_VALID_PATH",
    ("spin", 700): "UNKNOWN TIMEOUT TF_ERROR COLLISION_AHEAD",
    ("backup", 710): "UNKNOWN TIMEOUT TF_ERROR INVALID_INPUT COLLISION_AHEAD",
    ("drive on heading", 720): "UNKNOWN TIMEOUT TF_ERROR COLLISION_AHEAD INVALID_INPUT",
    ("navigator", 9000): "UNKNOWN FAILED_TO_LOAD_BEHAVIOR_TREE TF_ERROR TIMEOUT",
}
"""A dict from a Nav2 server and its first error code to the names of its consecutive codes."""
_USES = Counter(name for names in _ERRORS.values() for name in names.split())
ERROR_NAMES = {
    code: f"{server} {name}" if _USES[name] > 1 else name
    for (server, first), names in _ERRORS.items()
    for code, name in enumerate(names.split(), first)
}
"""A dict from Nav2's error codes to their names; the server's name precedes a name that several servers use."""


def error_name(code: int) -> str:
    """Return the name and number of an error code of Nav2; empty for code 0, which stands for no error."""
    return f"{ERROR_NAMES.get(code, 'error')} ({code})" if code else ""


@dataclass(frozen=True, slots=True)
class Outcome:
    """The outcome of a goal; None stands for a value that was not measured.

    Attributes:
        goal: the goal.
        result: `reached`, or the type of failure, such as `aborted`.
        reason: reason of the failure; empty for a reached goal, or if the reason is unknown.
        time: simulation time from the goal's acceptance to its end, s.
        path: length of the robot's path, m.
        error: distance from the goal to the robot's position as Nav2 estimates it, m.
        true_error: distance from the goal to the robot's true position, m.
        true_turn: angle between the goal's yaw and the robot's true yaw, rad.
        recoveries: number of Nav2's recovery behaviors.
        localization: mean and maximum distance between the estimated and the true position along the path, m.
    """

    goal: NavigationGoal
    result: str
    reason: str = ""
    time: float | None = None
    path: float | None = None
    error: float | None = None
    true_error: float | None = None
    true_turn: float | None = None
    recoveries: int | None = None
    localization: tuple[float, float] | None = None

    @property
    def reached(self) -> bool:
        """Whether Nav2 reports that the goal was reached."""
        return self.result == REACHED


HEADER = ("GOAL", "RESULT", "TIME", "PATH", "ERROR", "TRUE ERROR", "RECOVERIES", "LOCALIZATION ERROR", "REASON")
_UNKNOWN = "-"


def rows(outcomes: Sequence[Outcome]) -> list[tuple[str, ...]]:
    """Return the outcomes as rows of a table; the first row is the header."""
    return [HEADER, *(_cells(outcome) for outcome in outcomes)]


def _cells(outcome: Outcome) -> tuple[str, ...]:
    true, along = _metres(outcome.true_error), _UNKNOWN
    if outcome.true_turn is not None:
        true = f"{true}, {math.degrees(outcome.true_turn):.1f} deg"
    if outcome.localization is not None:
        along = "mean {:.3f} m, max {:.3f} m".format(*outcome.localization)
    return (
        outcome.goal.label,
        outcome.result,
        f"{outcome.time:.1f} s" if outcome.time is not None else _UNKNOWN,
        f"{outcome.path:.2f} m" if outcome.path is not None else _UNKNOWN,
        _metres(outcome.error),
        true,
        str(outcome.recoveries) if outcome.recoveries is not None else _UNKNOWN,
        along,
        outcome.reason,
    )


def _metres(value: float | None) -> str:
    return f"{value:.3f} m" if value is not None else _UNKNOWN


def write_junit(path: Path, outcomes: Sequence[Outcome], suite: str) -> None:
    """Write the outcomes as JUnit XML with a test case for each goal; times are in simulation time.

    Raises:
        OSError: the file cannot be written.
    """
    failed = sum(not outcome.reached for outcome in outcomes)
    total = f"{sum(outcome.time or 0.0 for outcome in outcomes):.3f}"
    counts = {"tests": str(len(outcomes)), "failures": str(failed), "time": total}
    element = ElementTree.Element("testsuite", {"name": _legal(suite), **counts})
    for outcome in outcomes:
        named = {"classname": _legal(suite), "name": _legal(outcome.goal.label), "time": f"{outcome.time or 0.0:.3f}"}
        case = ElementTree.SubElement(element, "testcase", named)
        properties = ElementTree.SubElement(case, "properties")
        for name, value in _measured(outcome).items():
            ElementTree.SubElement(properties, "property", {"name": name, "value": value})
        if not outcome.reached:
            text = f"{outcome.result}: {outcome.reason}" if outcome.reason else outcome.result
            ElementTree.SubElement(case, "failure", {"message": _legal(text)})
    ElementTree.indent(element)
    write_together({path: ElementTree.tostring(element, "utf-8", xml_declaration=True) + b"\n"})


def _legal(text: str) -> str:
    """Return a text with U+FFFD in place of characters that are not printable, because they may be illegal in XML."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _measured(outcome: Outcome) -> dict[str, str]:
    mean, largest = outcome.localization or (None, None)
    values = {
        "path_m": outcome.path,
        "error_m": outcome.error,
        "true_error_m": outcome.true_error,
        "true_turn_rad": outcome.true_turn,
        "recoveries": outcome.recoveries,
        "localization_error_mean_m": mean,
        "localization_error_max_m": largest,
    }
    return {name: f"{value:.6g}" for name, value in values.items() if value is not None}
