"""Interface for adding and removing the robots of a session."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.format.errors import UnknownEntityError, UsageError
from graphengine.format.spec import RobotUse


class Roster:
    """Adds and removes robots. This base class is for a session without a scene, which has no robots."""

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the robots that were spawned and are still there, oldest first."""
        return ()

    @property
    def uses(self) -> Mapping[str, str]:
        """Robot file or description of each robot by name, as `use` in a scene file."""
        return {}

    def add(self, name: str, use: RobotUse) -> None:
        """Add a robot to the scene; its graphs run after all others. After `stop` it returns to the pose at which it was added.

        Raises:
            CheckError: the robot or one of its graphs has errors.
            GraphError: physics, rays or one of its nodes cannot start. After any error, nothing has changed.
        """
        raise UsageError("a session without a scene cannot have robots")

    def remove(self, name: str) -> None:
        """Remove a robot, its graphs and its topics.

        Raises:
            UnknownEntityError: there is no such robot.
            UsageError: a node of another graph uses the robot.
        """
        raise UnknownEntityError("a session without a scene has no robots")

    def save(self) -> Any:
        """Return the set of robots of the session, for `restore`."""

    def restore(self, saved: Any) -> None:
        """Add and remove robots, so that the session has the same robots as when `save` was called.

        Raises:
            GraphError: a robot cannot be added again.
        """
