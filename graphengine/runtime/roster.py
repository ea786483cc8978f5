"""Interface for adding and removing the robots of a session."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.format.errors import UnknownEntityError, UsageError
from graphengine.format.spec import RobotUse


class Roster:
    """Adds robots to a session and removes them; this base class is for a session without a scene and refuses both."""

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the robots that were added while the session ran and still exist, oldest first."""
        return ()

    @property
    def uses(self) -> Mapping[str, str]:
        """Robot file or description of each robot by name, as in the key `use` of a scene file."""
        return {}

    def add(self, name: str, use: RobotUse, *, forced: bool = True) -> None:
        """Add a robot to the scene; its graphs run after all other graphs.

        A later `stop` returns the robot to its pose at the time of adding. After an error, the session continues unchanged.

        Args:
            name: name of the robot.
            use: robot file, pose and further settings.
            forced: whether the robot is added even if it overlaps other entities; the floor does not count.

        Raises:
            BlockedPoseError: `forced` is false, and the robot would overlap others.
            CheckError: the robot or one of its graphs has errors.
            GraphError: physics with the robot, or a node of the robot, cannot start.
            UsageError: the session has no scene.
        """
        raise UsageError("a session without a scene cannot have robots")

    def remove(self, name: str) -> None:
        """Remove a robot, its graphs and its topics.

        Raises:
            UnknownEntityError: no robot has the name.
            UsageError: a node of another graph uses the robot.
        """
        raise UnknownEntityError("a session without a scene has no robots")

    def save(self) -> Any:
        """Return the robots of the session, in a form for `restore`."""

    def restore(self, saved: Any) -> None:
        """Add and remove robots until the session has the same robots as at the call of `save`.

        Raises:
            GraphError: a robot cannot be added again.
        """
