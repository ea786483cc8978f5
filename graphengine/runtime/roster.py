"""The robots of a session, as its commands add and remove them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphengine.format.errors import UnknownEntityError, UsageError
from graphengine.format.spec import RobotUse


class Roster:
    """The robots of a session without a scene, which has none; a scene's roster extends it."""

    @property
    def spawned(self) -> Sequence[str]:
        """Names of the robots that were spawned and are still there, oldest first."""
        return ()

    @property
    def uses(self) -> Mapping[str, str]:
        """Robot file or description of each robot, as `use` in a scene file, by the robot's name."""
        return {}

    def add(self, name: str, use: RobotUse) -> None:
        """Put a robot into the scene, and run its graphs after the others. On `stop` it goes back to where it was put.

        Raises:
            CheckError: the robot, or one of its graphs, has errors.
            GraphError: physics, rays or one of its nodes cannot begin. After any error nothing has changed.
        """
        raise UsageError("a session without a scene has no place for robots")

    def remove(self, name: str) -> None:
        """Remove a robot, its graphs and its topics.

        Raises:
            UnknownEntityError: there is no such robot.
            UsageError: a node of another graph uses the robot.
        """
        raise UnknownEntityError("a session without a scene has no robots")

    def save(self) -> Any:
        """Which robots are there."""

    def restore(self, saved: Any) -> None:
        """Put back the robots that were there when `save` was called, and remove the others.

        Raises:
            GraphError: a robot cannot be put back.
        """
