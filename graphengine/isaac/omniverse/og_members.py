"""Attribute lookup of OmniGraph's controllers, on the class and on instances; unknown members are stubs."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from graphengine.isaac.omniverse.graph_recorder import GraphRecorder
from graphengine.isaac.omniverse.og_edit import OPENED
from graphengine.isaac.omniverse.og_names import NotThereError
from graphengine.isaac.omniverse.stubs import ELSEWHERE, StubObject, member


class either:  # noqa: N801  used as a decorator
    """A method of the class and of its instances, as those of OmniGraph's controllers are; `self` is None for the class."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __get__(self, instance: Any, owner: Any) -> Callable[..., Any]:
        return functools.partial(self.call, owner, instance)

    def call(self, owner: Any, instance: Any, *arguments: Any, **named: Any) -> Any:
        """Call it; what a USD file may hold is left out where that is assumed."""
        try:
            return self.function(owner, instance, *arguments, **named)
        except NotThereError as error:
            if not owner.recorder.assumed:
                raise
            owner.recorder.leave_out(str(error), "", OPENED)
            return StubObject(ELSEWHERE, owner.recorder)


class Open(type):
    """A class whose other members are stubs."""

    recorder: GraphRecorder

    def __getattr__(cls, name: str) -> Any:
        return member("omni.graph.core.Controller", name, cls.recorder)
