"""Features of simulation_interfaces that this simulator has, by the standard's numbers, and the one world that it has."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from graphengine.control.simulation_interfaces.resources import FORMATS
from graphengine.control.simulation_interfaces.results import UNSUPPORTED, RefusedError
from graphengine.format.version import __version__
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.loaded_scene import LoadedScene

OF_SERVICES: Mapping[str, tuple[int, ...]] = {
    "spawn_entity": (0, 9),  # SPAWNING, SPAWNING_RESOURCE_STRING
    "delete_entity": (1,),
    "get_entities": (6, 8),  # ENTITY_BOUNDS_BOX and ENTITY_CATEGORIES in filters
    "set_entity_info": (4, 13),  # ENTITY_TAGS, ENTITY_INFO_SETTING
    "get_entity_bounds": (5,),
    "get_entity_state": (10,),
    "set_entity_state": (11,),
    "get_entity_info": (12,),
    "get_spawnables": (14,),
    "reset_simulation": (20, 21, 22, 23),  # with all scopes
    "get_simulation_state": (24,),
    "set_simulation_state": (25, 26),  # with a pause
    "step_simulation": (31, 32),  # one, several
    "simulate_steps": (33,),
    "get_current_world": (44,),
    "spawn_entities": (50,),
}
"""Codes of SimulatorFeatures that a service stands for."""


def get_features(scene: LoadedScene, offered: Sequence[str]) -> Callable[[SessionCore, Any, Any], None]:
    """What answers GetSimulatorFeatures; `offered` grows while services are offered."""

    def answer(session: SessionCore, request: Any, response: Any) -> None:
        codes = sorted(code for name in offered for code in OF_SERVICES.get(name, ()))
        response.features.features = np.array(codes, np.uint16)
        response.features.spawn_formats = list(FORMATS) if "spawn_entity" in offered else []
        response.features.custom_info = f"graphengine {__version__}; a step is a tick of {session.clock.delta:g} s"

    return answer


def unsupported(session: SessionCore, request: Any, response: Any) -> None:
    """Answer what this simulator does not do."""
    raise RefusedError(UNSUPPORTED, "not a feature of this simulator, or of a session without a scene")


def get_current_world(scene: LoadedScene) -> Callable[[SessionCore, Any, Any], None]:
    """What answers GetCurrentWorld."""

    def answer(session: SessionCore, request: Any, response: Any) -> None:
        assert scene.world is not None
        spec = scene.world.scenery.scene.spec
        response.world.name = spec.scene
        response.world.description = spec.doc
        response.world.world_resource.uri = spec.world

    return answer
