"""Creates the services of `simulation_interfaces` on a transport; the session executes the requests between two ticks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any

import numpy as np

from graphengine.control.service_host import ServiceHost
from graphengine.control.simulation_interfaces import entities, states
from graphengine.control.simulation_interfaces.action import SimulateSteps
from graphengine.control.simulation_interfaces.resources import FORMATS
from graphengine.control.simulation_interfaces.results import OK, UNSUPPORTED, RefusedError, code_of, text_of
from graphengine.control.simulation_interfaces.spawning import SceneFiles, Spawning
from graphengine.format.version import __version__
from graphengine.messages.interfaces import MessageTypeError
from graphengine.ros.transport import Complain, Transport
from graphengine.runtime.command_queue import CommandQueue
from graphengine.runtime.session_core import SessionCore

PACKAGE = "simulation_interfaces"

_LEFT_OUT = ("get_available_worlds", "load_world", "unload_world", "get_named_poses", "get_named_pose_bounds")
"""Services that are not supported, because a session has one world and no named poses.

The services exist nevertheless, so that a call gets an error instead of waiting for a server.
"""
_SPAWNING = 0
"""SimulatorFeatures code for spawning entities."""

Answer = Callable[[SessionCore, Any, Any], None]
"""A function that fills in a response in the session's thread. An exception determines the result code."""


class SimulationInterfaces:
    """The `simulation_interfaces` services of one session.

    Args:
        queue: command queue of the session.
        scene: scene file of the session, and the folders from which its files may be read; None for a graph without a scene.
        transport: transport on which the services are created; services whose types the transport lacks are left out.
        complain: called with one warning about left out services, and for each service with one about malformed requests.
        namespace: namespace of the services and the action; `/` is the root namespace.
    """

    def __init__(
        self, queue: CommandQueue, scene: SceneFiles | None, transport: Transport, complain: Complain, namespace: str
    ) -> None:
        self._queue = queue
        self._above = namespace.rstrip("/")
        self._offers = ServiceHost(transport, complain)
        self._features: list[int] = []
        """SimulatorFeatures codes of the created services."""
        missing: list[str] = []
        for name, (answer, features) in self._services(scene).items():
            try:
                self._offer(name, answer)
                self._features += features
            except MessageTypeError:
                missing.append(name)
        self._parts: list[ServiceHost | SimulateSteps] = [self._offers]
        try:
            self._parts.append(SimulateSteps(queue, transport, self._offers, f"{self._above}/simulate_steps"))
            self._features.append(33)
        except MessageTypeError:
            missing.append("simulate_steps")
        if missing:
            complain(f"services left out because {PACKAGE} is not installed or older than 1.5: {', '.join(missing)}")

    def _services(self, scene: SceneFiles | None) -> Mapping[str, tuple[Answer, Sequence[int]]]:
        """Return the handler and the SimulatorFeatures codes of each service, by service name."""
        services: dict[str, tuple[Answer, Sequence[int]]] = {
            "get_simulator_features": (self._get_features, ()),
            "get_simulation_state": (states.get_state, (24,)),
            "set_simulation_state": (states.set_state, (25, 26)),  # with a pause
            "reset_simulation": (states.reset, (20, 21, 22, 23)),  # with all scopes
            "step_simulation": (states.step, (31, 32)),  # one, several
        }
        spawning = Spawning(scene)
        of_scenes: dict[str, tuple[Answer, Sequence[int]]] = {
            "get_entities": (entities.get_entities, (6, 8)),  # ENTITY_BOUNDS_BOX and ENTITY_CATEGORIES in filters
            "get_entities_states": (entities.get_entities_states, ()),
            "get_entity_state": (entities.get_entity_state, (10,)),
            "set_entity_state": (entities.set_entity_state, (11,)),
            "get_entity_info": (entities.get_entity_info, (12,)),
            "set_entity_info": (entities.set_entity_info, (4, 13)),  # ENTITY_TAGS, ENTITY_INFO_SETTING
            "get_entity_bounds": (entities.get_entity_bounds, (5,)),
            "spawn_entity": (spawning.spawn_entity, (_SPAWNING, 9)),  # SPAWNING_RESOURCE_STRING
            "spawn_entities": (spawning.spawn_entities, (50,)),
            "delete_entity": (entities.delete_entity, (1,)),
            "get_spawnables": (spawning.get_spawnables, (14,)),
            "get_current_world": (spawning.get_current_world, (44,)),
        }
        left_out = _LEFT_OUT if scene is not None else (*of_scenes, *_LEFT_OUT)
        return {**services, **of_scenes, **dict.fromkeys(left_out, (_refuse, ()))}

    def _get_features(self, session: SessionCore, request: Any, response: Any) -> None:
        """Answer GetSimulatorFeatures with the features, the resource formats and the version."""
        response.features.features = np.array(sorted(self._features), np.uint16)
        response.features.spawn_formats = list(FORMATS) if _SPAWNING in self._features else []
        response.features.custom_info = f"graphengine {__version__}; a step is a tick of {session.clock.delta:g} s"

    def _offer(self, name: str, answer: Answer) -> None:
        kind = f"{PACKAGE}/srv/{''.join(part.capitalize() for part in name.split('_'))}"

        def handle(request: Any, response: Any) -> Future[Any]:
            return self._queue.ask(lambda session: answer(session, request, response))

        self._offers.add(f"{self._above}/{name}", kind, handle, _finish)

    def close(self) -> None:
        """Destroy all services and the action. Safe to call twice."""
        for part in self._parts:
            part.close()


def _refuse(session: SessionCore, request: Any, response: Any) -> None:
    """Reject every request with the result code for unsupported features."""
    raise RefusedError(UNSUPPORTED, "not supported by this simulator, or by a session without a scene")


def _finish(response: Any, error: BaseException | None) -> None:
    """Write the result code and the error text of a request into its response."""
    result = getattr(response, "result", None)
    if result is None:  # get_simulator_features cannot fail
        return
    result.result = OK if error is None else code_of(error)
    if error is not None:
        result.error_message = text_of(error)
