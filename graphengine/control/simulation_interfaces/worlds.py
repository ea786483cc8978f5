"""The world of a session, which is one for all of its life."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphengine.control.simulation_interfaces.results import UNSUPPORTED, RefusedError
from graphengine.runtime.session import Session
from graphengine.scene.assembly import Assembly


def unsupported(session: Session, request: Any, response: Any) -> None:
    """Answer what this simulator does not do."""
    raise RefusedError(UNSUPPORTED, "not a feature of this simulator, or of a session without a scene")


def get_current_world(assembly: Assembly) -> Callable[[Session, Any, Any], None]:
    """What answers GetCurrentWorld."""

    def answer(session: Session, request: Any, response: Any) -> None:
        assert assembly.loaded is not None
        scene = assembly.loaded.scenery.scene.spec
        response.world.name = scene.scene
        response.world.description = scene.doc
        response.world.world_resource.uri = scene.world

    return answer
