"""Offers the services of `simulation_interfaces` on a transport, and answers them at the session's desk."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

from graphengine.control.parameters import Parameters
from graphengine.control.service_host import Offers
from graphengine.control.simulation_interfaces import entities, features, states
from graphengine.control.simulation_interfaces.action import SimulateSteps
from graphengine.control.simulation_interfaces.results import OK, code_of, text_of
from graphengine.control.simulation_interfaces.spawning import Spawning
from graphengine.messages.interfaces import MessageTypeError
from graphengine.ros.transport import Transport
from graphengine.runtime.command_queue import Desk
from graphengine.runtime.session_core import SessionCore
from graphengine.scene.loaded_scene import LoadedScene

PACKAGE = "simulation_interfaces"

_LEFT_OUT = ("get_available_worlds", "load_world", "unload_world", "get_named_poses", "get_named_pose_bounds")
"""Services that say so, which is better than to let callers wait: a session has one world, and a scene names no poses."""

Answer = Callable[[SessionCore, Any, Any], None]
"""Fills in an answer, in the session's thread; what it raises becomes the answer's result."""


class SimulationInterfaces:
    """The services of one session.

    Args:
        desk: of the session.
        scene: that the session was made from.
        transport: to offer them on; what of its types is not there is left out.
        complain: told once of what is left out, and of a peer that sends what is no request.
        namespace: where the services and the action are; `/` for none.
    """

    def __init__(
        self,
        desk: Desk,
        scene: LoadedScene,
        transport: Transport,
        complain: Callable[[str], None],
        namespace: str = "/",
    ) -> None:
        self._desk = desk
        self._above = namespace.rstrip("/")
        self._offers = Offers(transport, complain)
        missing: list[str] = []
        offered: list[str] = []
        for name, answer in self._answers(scene, offered).items():
            try:
                self._offer(name, answer)
                offered += [name] if answer is not features.unsupported else []
            except MessageTypeError:
                missing.append(name)
        self._parts: list[Offers | SimulateSteps | Parameters] = [self._offers]
        try:
            self._parts.append(SimulateSteps(desk, transport, complain, f"{self._above}/simulate_steps"))
            offered.append("simulate_steps")
        except MessageTypeError:
            missing.append("simulate_steps")
        if transport.node:
            self._parts.append(Parameters(desk, transport, complain))
        if missing:
            complain(f"not offered, as {PACKAGE} is not installed, or older than 1.5: {', '.join(missing)}")

    def _answers(self, scene: LoadedScene, offered: list[str]) -> Mapping[str, Answer]:
        """What answers each service of the package."""
        answers: dict[str, Answer] = {
            "get_simulator_features": features.get_features(scene, offered),
            "get_simulation_state": states.get_state,
            "set_simulation_state": states.set_state,
            "reset_simulation": states.reset,
            "step_simulation": states.step,
        }
        spawning = Spawning(scene)
        of_scenes: dict[str, Answer] = {
            "get_entities": entities.get_entities,
            "get_entities_states": entities.get_entities_states,
            "get_entity_state": entities.get_entity_state,
            "set_entity_state": entities.set_entity_state,
            "get_entity_info": entities.get_entity_info,
            "set_entity_info": entities.set_entity_info,
            "get_entity_bounds": entities.get_entity_bounds,
            "spawn_entity": spawning.spawn_entity,
            "spawn_entities": spawning.spawn_entities,
            "delete_entity": entities.delete_entity,
            "get_spawnables": spawning.get_spawnables,
            "get_current_world": features.get_current_world(scene),
        }
        if scene.world is None:
            of_scenes = dict.fromkeys(of_scenes, features.unsupported)
        return {**answers, **of_scenes, **dict.fromkeys(_LEFT_OUT, features.unsupported)}

    def _offer(self, name: str, answer: Answer) -> None:
        kind = f"{PACKAGE}/srv/{''.join(part.capitalize() for part in name.split('_'))}"

        def handle(request: Any, response: Any) -> Future[Any]:
            return self._desk.ask(lambda session: answer(session, request, response))

        self._offers.add(f"{self._above}/{name}", kind, handle, _finish)

    def close(self) -> None:
        """Withdraw the services; safe to call twice."""
        for part in self._parts:
            part.close()


def _finish(response: Any, error: BaseException | None) -> None:
    """Write into an answer what came of the request."""
    result = getattr(response, "result", None)
    if result is None:  # get_simulator_features cannot fail
        return
    result.result = OK if error is None else code_of(error)
    if error is not None:
        result.error_message = text_of(error)
