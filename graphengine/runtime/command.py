"""The base classes of the commands of a session."""

from __future__ import annotations

from abc import abstractmethod
from typing import Annotated, Any, ClassVar

from pydantic import Field

from graphengine.devices.stage import Prim
from graphengine.format.errors import UnknownEntityError
from graphengine.format.spec import Spec
from graphengine.format.wording import unknown
from graphengine.runtime.session_core import SessionCore

EntityName = Annotated[str, Field(min_length=1, max_length=1000)]
JointNumbers = dict[EntityName, float]
"""A dict from joint names to numbers."""


class Command(Spec):
    """Base class of the commands that a session executes between two ticks; the fields are the arguments in JSON."""

    recorded: ClassVar[bool] = False
    """Whether the command affects the simulation; recordings and replays have only such commands."""
    admitted: ClassVar[bool] = False
    """Whether `apply` calls `SessionCore.admit`, which refuses the command within a tick and in a failed session."""

    @classmethod
    def command_name(cls) -> str:
        """Return the name of the command in `graphrun ctl` and in recordings: by default, the class's name in lower case."""
        return cls.__name__.lower()

    def apply(self, session: SessionCore) -> Any:
        """Execute the command in the session's thread, between two ticks; return a result of JSON types."""
        if self.admitted:
            session.admit()
        return self._apply(session)

    @abstractmethod
    def _apply(self, session: SessionCore) -> Any: ...


def find_robot(session: SessionCore, name: str) -> Prim:
    """Return the prim of the robot with this name.

    Raises:
        UnknownEntityError: no robot has the name.
    """
    robots = session.services.stage.robots()
    if name not in robots:
        raise UnknownEntityError(unknown("robot", name, robots))
    return robots[name]


class ChangeCommand(Command):
    """Base class of the commands that change the world or nodes; a recording contains each command that succeeded."""

    recorded = True
    admitted = True

    def _record(self, session: SessionCore, **arguments: Any) -> None:
        """Record the executed command, with arguments that have the same effect in a replay."""
        session.note(self.command_name(), arguments)
