"""Writes measured values into a robot's graph and robot files; it changes only numbers in their text."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from graphengine.api.scene import Scene, loaded_of, world_of
from graphengine.bringup.calibration.figures import Calibration, Covariances
from graphengine.bringup.calibration.robot_interface import inputs_named
from graphengine.compiler.graph import Graph, Instance
from graphengine.descriptions.robot_files.robot_file import RobotFile
from graphengine.format.atomic_write import write_together
from graphengine.format.document import Document, Location
from graphengine.format.errors import UsageError
from graphengine.format.files import near
from graphengine.format.yaml_patch import PatchError, set_value

SLIPPING = 0.2
"""Maximum slip of straight motions at which rolling radius, track and wheel base are written; larger slip distorts them."""
SAME = 5e-4
"""Maximum relative difference between the measured value and the value in the file at which the file does not change."""
LEAST = 1e-12
"""Smallest measured value to write; smaller values are rounding noise."""
_REMEDY = "copy the file into your project, use the copy in your robot file or scene, and calibrate that scene"
_PARAMETER = re.compile(r"\$\(([^$()]*)\)")
_COVARIANCES = {
    "distanceVariance": "distance_variance",
    "headingVarianceByDistance": "heading_variance_by_distance",
    "headingVarianceByTurn": "heading_variance_by_turn",
}


@dataclass(frozen=True, slots=True)
class Change:
    """A measured value to write into a file.

    Attributes:
        path: file to change.
        location: keys and indices that lead to the value in the file.
        node: address of the input, with graph and node, such as `cmd_vel/DiffController.wheelRadius`.
        input: name of the input without graph and node.
        old: value before the change.
        new: measured value, rounded to 5 digits.
    """

    path: Path
    location: Location
    node: str
    input: str
    old: float
    new: float


_Place = tuple[Document, Location]
"""A file, and the keys and indices that lead to the value of an input in it."""


def write_figures(scene: Scene, calibration: Calibration) -> tuple[list[Change], list[str]]:
    """Write the measured wheel radius, track, wheel base and covariances into the files that set these inputs.

    Returns:
        The changes, and notes on inputs that were not written.

    Raises:
        OSError: a file cannot be read or written; no file has changed.
        UsageError: a file that ships with the package sets a radius, track or wheel base; no file has changed.
    """
    found, notes = find_changes(scene, calibration)
    changes = [change for change in found if not _ships(scene, change)]
    for change in found:
        if change not in changes:
            notes.append(_refusal(change))
            if change.input not in _COVARIANCES:
                raise UsageError(f"--write: {_refusal(change)}\n  {_REMEDY}")
    texts: dict[Path, str] = {}
    comment = f"graphrun calibrate: measured at {calibration.speed:.4g} m/s and {calibration.turn_speed:.4g} rad/s"
    written = []
    for change in changes:
        text = texts[change.path] if change.path in texts else change.path.read_bytes().decode("utf-8-sig")
        try:
            texts[change.path] = set_value(text, change.location, change.new, comment)
            written.append(change)
        except PatchError as error:
            notes.append(f"{change.node}: not written to {near(str(change.path))}: {error}")
    write_together({path: text.encode() for path, text in texts.items()})
    return written, notes


def write_input(scene: Scene, robot: str, name: str, value: float, comment: str) -> bool:
    """Write a number into the robot's file that sets an input of its graphs; return whether the number was written.

    Args:
        scene: scene with the robot.
        robot: name of the robot.
        name: name of the input; its value is a scalar.
        value: new value.
        comment: comment beside the value.
    """
    file = world_of(scene).robots[robot].file
    for graph, instance, _, _ in inputs_named(loaded_of(scene).planned, name):
        place = _find_place(graph, instance, name, None, file) if graph.name.partition("/")[0] == robot else None
        if place is not None:
            document, location = place
            path = Path(document.source.path)
            try:
                text = set_value(path.read_bytes().decode("utf-8-sig"), location, value, comment)
            except PatchError:
                continue
            write_together({path: text.encode()})
            return True
    return False


def find_changes(scene: Scene, calibration: Calibration) -> tuple[list[Change], list[str]]:
    """Return a change for each input whose value differs from the measurement, and notes on inputs that cannot be written."""
    file = world_of(scene).robots[calibration.robot].file
    changes: dict[tuple[Path, Location], Change] = {}
    notes = []
    slipping = [one.name for one in calibration.motions if one.kind == "straight" and abs(one.slip or 0.0) > SLIPPING]
    if slipping:
        calibration = replace(calibration, wheel_radius=None, track=None, wheel_base=None)
        notes.append(f"wheel radius, track and wheel base are not written: the wheels slip ({', '.join(slipping)})")
    for graph, instance, name, index, old, new in _wanted(scene, calibration):
        label = f"{graph.name.partition('/')[2]}/{instance.id}.{name}"
        if new < LEAST:
            continue
        place = _find_place(graph, instance, name, index, file)
        if place is not None and (value := place[0].find(*place[1])) is not None:
            old = float(value.data)  # an override of `--set` is not in the file
        if abs(new - old) <= SAME * abs(new):
            continue
        if place is None and old == 0.0 and name not in _COVARIANCES:
            continue  # not set; another input of the node replaces it
        if place is None:
            notes.append(f"{label}: not written, as the file does not set it to one number; measured {new:.5g}")
            continue
        document, location = place
        change = Change(Path(document.source.path), location, label, name, old, float(f"{new:.5g}"))
        first = changes.setdefault((change.path, location), change)
        if first.new != change.new:
            notes.append(f"{label}: not written, as it shares its value with {first.node}; measured {new:.5g}")
    turns = [motion.share for motion in calibration.motions if motion.kind == "turn"]
    factor = len(turns) / sum(turns) if turns and sum(turns) else 1.0
    if calibration.kinematics in ("mecanum", "omni") and abs(factor - 1.0) > SAME:
        notes.append(f"wheelPositions are not written; multiplied by {factor:.4f} they give the commanded turn rate")
    return list(changes.values()), notes


def _wanted(scene: Scene, result: Calibration) -> Iterator[tuple[Graph, Instance, str, int | None, float, float]]:
    """Yield each input with a measured value, as (graph, node, input, array index or None, old value, new value)."""
    figures = {
        **dict.fromkeys(("wheelRadius", "frontWheelRadius", "backWheelRadius"), result.wheel_radius),
        **dict.fromkeys(("wheelDistance", "trackWidth"), result.track),
        "wheelBase": result.wheel_base,
        **dict.fromkeys(_COVARIANCES),
    }
    for graph, instance, name, old in inputs_named(loaded_of(scene).planned, *figures):
        if graph.name.partition("/")[0] != result.robot:
            continue
        new = figures[name]
        if name in _COVARIANCES:
            new = getattr(_covariances(scene, result, graph), _COVARIANCES[name])
        elif name == "wheelDistance" and new is not None:
            siblings = {other.name: instance.value(other.field) for other in instance.cls.fields.values()}
            new = _without_factors(new, siblings, result)
        if new is None:
            continue
        if isinstance(old, np.ndarray):
            for index, value in enumerate(old.tolist()):
                yield graph, instance, name, index, float(value), new
        else:
            yield graph, instance, name, None, float(old), new


def _without_factors(track: float, inputs: Mapping[str, Any], result: Calibration) -> float:
    """Return the input `wheelDistance` for a track, m.

    The node multiplies `wheelDistance` by `wheelDistanceMultiplier`; a mecanum node adds `wheelBase`, which is subtracted here.
    """
    if result.kinematics == "mecanum":
        track -= abs(float(inputs.get("wheelBase", 0.0)))
    return track / (float(inputs.get("wheelDistanceMultiplier", 1.0)) or 1.0)


def _covariances(scene: Scene, result: Calibration, graph: Graph) -> Covariances:
    """Return the covariances of the graph's odometry topic; if the graph publishes no odometry, of any topic of the robot.

    Of several topics, the topic with the largest variance of the distance counts.
    """
    topics = {claim.topic for claim in scene.topics if claim.direction == "publish" and claim.graph == graph.name}
    own = [one for one in result.odometry if one.topic in topics] or list(result.odometry)
    known = [one.covariances for one in own if one.covariances.distance_variance is not None]
    return max(known, key=lambda one: one.distance_variance or 0.0, default=Covariances())


def _find_place(graph: Graph, instance: Instance, name: str, index: int | None, file: RobotFile) -> _Place | None:
    """Return the file, and the location in it, that set an input to a number; None if no file does.

    For covariances that no file sets, return the location in the graph file at which to add the input.
    """
    entry = instance.entry
    if name in entry.given or f"inputs:{name}" in entry.given:
        return None
    key = next((key for key in (name, f"inputs:{name}") if key in entry.spec.inputs), None)
    if key is None and (name not in _COVARIANCES or entry.via):
        return None
    location: Location = (*entry.location, "inputs", key or name)
    if key is None:
        return entry.document, location
    levels = instance.id.split("/")
    return _lead_out(entry.document, location, index, graph, levels[:-1], file)


def _lead_out(
    document: Document, location: Location, index: int | None, graph: Graph, around: list[str], file: RobotFile
) -> _Place | None:
    """Follow graph parameters from a location in a graph file to a number; return the file and the location of the number.

    Args:
        document: file to start in.
        location: keys and indices in the file.
        index: index in an array; None for a scalar.
        graph: graph of the input.
        around: enclosing subgraphs, outermost first.
        file: the robot file, which may set parameters of the graph.

    Returns:
        The file and the location of the number, or those at which the robot file can set the parameter; None without either.
    """
    value = document.find(*location)
    data = value.data if value is not None else None
    if isinstance(data, list) and index is not None and index < len(data):
        return _lead_out(document, (*location, index), None, graph, around, file)
    if isinstance(data, int | float) and not isinstance(data, bool):
        return document, location
    parameter = _PARAMETER.fullmatch(data) if isinstance(data, str) else None
    if parameter is None or len(around) > 1:
        return None
    if around:  # the parameter of a subgraph, which a node of the outermost file gives
        outer = graph.flat.loaded.document
        given: Location = ("nodes", around[0], "parameters", parameter[1])
        return _lead_out(outer, given, index, graph, [], file) if outer.find(*given) is not None else None
    use = ("graphs", graph.name.partition("/")[2])
    given = (*use, "parameters", parameter[1])
    holder = file.document(*given)
    value = holder.find(*given)
    if value is None:  # the graph's default applies; a file cannot override one element of a default array
        return (file.document(*use, "use"), given) if index is None else None
    if isinstance(value.data, list) and index is not None:
        return holder, (*given, index)
    return (holder, given) if isinstance(value.data, int | float) else None


def _ships(scene: Scene, change: Change) -> bool:
    """Return whether a change is in a file that ships with the package."""
    base, path = loaded_of(scene).files.base.resolve(), change.path.resolve()
    return any(path.is_relative_to(base / folder) for folder in ("graphs", "scenes"))


def _refusal(change: Change) -> str:
    file = near(str(change.path))
    return f"{change.node}: not written, as {file} ships with graphengine; measured {change.new:g}"
