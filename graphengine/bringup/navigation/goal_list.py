"""Navigation goals: poses in the map, and the YAML file that lists them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from graphengine.format import spec_reader
from graphengine.format.diagnostics import Findings
from graphengine.format.spec import Format, Spec

Coordinate = Annotated[float, Field(ge=-1e6, le=1e6)]


@dataclass(frozen=True, slots=True)
class NavigationGoal:
    """A pose in the map: position in m, yaw in rad."""

    x: float
    y: float
    yaw: float = 0.0
    name: str = ""

    @property
    def label(self) -> str:
        """Name of the goal, or its pose as text if it has no name."""
        return self.name or f"{self.x:g} {self.y:g} {self.yaw:.4g}"


class GoalSpec(Spec):
    """A goal in a file: a position in m and a yaw in rad, in the frame `map`."""

    x: Coordinate
    y: Coordinate
    yaw: Annotated[float, Field(ge=-1e3, le=1e3)] = 0.0
    name: Annotated[str, Field(max_length=100)] = ""


class GoalListSpec(Spec):
    """Format of the YAML file that lists goals."""

    format: Format = 1
    goals: Annotated[tuple[GoalSpec, ...], Field(strict=False, min_length=1, max_length=10_000)]


def read_goals(path: Path) -> list[NavigationGoal]:
    """Read the goals of a YAML file.

    Raises:
        CheckError: the file has errors; each finding has a line and a column.
    """
    findings = Findings()
    read = spec_reader.read(GoalListSpec, path, findings)
    findings.raise_errors()
    assert read is not None
    return [NavigationGoal(goal.x, goal.y, goal.yaw, goal.name) for goal in read.spec.goals]
