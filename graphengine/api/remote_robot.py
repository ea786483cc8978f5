"""A robot of a run in another process of the same user, which is reached over the control channel of the run."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from graphengine.control import runs
from graphengine.control.client import Client, find
from graphengine.devices.rotation import Quaternion, Vector3
from graphengine.format.errors import ControlError


@dataclass(frozen=True, slots=True)
class RemoteState:
    """The state of a robot in a run.

    Attributes:
        time: simulation time, s.
        paused: whether the run is paused.
        position: position of the base link in the world, m.
        orientation: orientation of the base link in the world, (x, y, z, w).
    """

    time: float
    paused: bool
    position: Vector3
    orientation: Quaternion


class RemoteRobot:
    """A robot of a run in another process.

    Args:
        run: name or process id of the run; empty takes the only run that has a robot in the namespace.
        namespace: namespace of the robot.
        patience: maximum wall time to wait for an answer of the run, s.

    Raises:
        ControlError: no run has the name or process id.
        UsageError: `run` is empty, and several runs are possible.
    """

    def __init__(self, run: str, namespace: str, patience: float) -> None:
        self._namespace, self._patience = namespace.strip("/"), patience
        self.entry = self._find(run)
        """The entry of the run in the list of running sessions."""
        self._client, self._name = Client(self.entry, patience), ""

    def state(self) -> RemoteState:
        """Ask the run for the state of the robot.

        Raises:
            ControlError: the run does not answer, or has no robot in the namespace.
        """
        answer: Mapping[str, Any] = self._client.ask("state")
        robots = _robots(answer)
        if self._namespace not in robots:
            there = ", ".join(f"/{name}" for name in robots) or "none"
            raise ControlError(f"{self.entry} has no robot in the namespace /{self._namespace} (robots: {there})")
        robot = robots[self._namespace]
        self._name = robot["name"]
        x, y, z = robot["position"]
        return RemoteState(float(answer["time"]), answer["state"] == "paused", (x, y, z), robot["orientation"])

    def clearance(self, position: tuple[float, float], margin: float) -> Mapping[str, float]:
        """Ask for the distances (m) of all that is within a margin of the robot at a position, by name; call `state` before.

        Raises:
            ControlError: the run ends, or is of a version without this command.
        """
        with Client(self.entry, self._patience) as client:
            found = client.ask("clearance", {"entity": self._name, "position": position, "margin": margin})
        near: Mapping[str, float] = found["near"]
        return near

    def interrupt(self) -> None:
        """End a `state` in progress with ControlError. May be called from another thread."""
        self._client.interrupt()

    def close(self) -> None:
        """Close the connection; the run continues."""
        self._client.close()

    def _find(self, run: str) -> runs.Entry:
        there = runs.running(os.environ)
        fitting = [entry for entry in there if self._is_in(entry)] if not run and len(there) > 1 else []
        return fitting[0] if len(fitting) == 1 else find(run)

    def _is_in(self, entry: runs.Entry) -> bool:
        """Return whether a run has a robot in the namespace."""
        try:
            with Client(entry, self._patience) as client:
                return self._namespace in _robots(client.ask("state"))
        except ControlError:  # the run has ended meanwhile
            return False


def _robots(state: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    """Return the robots in the state of a run, by namespace without slashes at the ends."""
    return {robot["namespace"].strip("/"): robot for robot in state["robots"]}
