"""Handles requests to spawn entities and to describe the world."""

from __future__ import annotations

import itertools
import re
from typing import Any

from pydantic import ValidationError

from graphengine.control.simulation_interfaces.entities import pose_in_world
from graphengine.control.simulation_interfaces.resources import name_of, spawnables, use_of
from graphengine.control.simulation_interfaces.results import OK, RefusedError, code_of, text_of
from graphengine.format.diagnostics import CheckError
from graphengine.format.errors import BlockedPoseError, GraphError, PhysicsError, RecordingError
from graphengine.format.files import Files
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec import Orientation, RobotUse
from graphengine.format.spec_reader import Loaded
from graphengine.messages.definitions import DEFINITIONS
from graphengine.runtime.entity_commands import Spawn
from graphengine.runtime.session_core import SessionCore

_NAME_NOT_UNIQUE, _NAME_INVALID = 101, 102
_NAMESPACE_INVALID, _PARSE_ERROR, _MISSING_ASSETS, _INVALID_POSE = 105, 106, 107, 109
_SOME_FAILED = 150
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,199}")
MAX_AT_ONCE = 1000
"""Maximum number of entities that one request spawns."""


SceneFiles = tuple[Loaded[SceneSpec], Files]
"""The scene file of a session, and the folders from which its files may be read."""


class Spawning:
    """Handlers of the services that need the scene: spawning entities, and describing resources and the world."""

    def __init__(self, scene: SceneFiles | None) -> None:
        self._scene = scene

    def spawn_entity(self, session: SessionCore, request: Any, response: Any) -> None:
        """Answer SpawnEntity: add a robot unless it overlaps others; the response has the name, and a warning about floors."""
        name, warning = self._spawn(session, request, request.uri, request.resource_string)
        response.entity_name, response.result.error_message = name, warning

    def spawn_entities(self, session: SessionCore, request: Any, response: Any) -> None:
        """Answer SpawnEntities: spawn the entities one by one; an entity that fails does not affect the others."""
        if len(request.spawn_requests) > MAX_AT_ONCE:
            raise RefusedError(_SOME_FAILED, f"more than {MAX_AT_ONCE} entities in one request")
        failed = 0
        for one in request.spawn_requests:
            result = DEFINITIONS.initial("simulation_interfaces/msg/SpawnResult")
            response.results.append(result)
            result.result.result = OK
            try:
                resource = one.entity_resource
                name, warning = self._spawn(session, one, resource.uri, resource.resource_string)
                result.entity_name, result.result.error_message = name, warning
            except RecordingError:
                raise
            except GraphError as error:
                failed += 1
                result.result.result, result.result.error_message = code_of(error), text_of(error)
        if failed:
            raise RefusedError(_SOME_FAILED, f"{failed} of {len(request.spawn_requests)} entities could not be spawned")

    def get_spawnables(self, session: SessionCore, request: Any, response: Any) -> None:
        """Answer GetSpawnables with the resources that can be spawned, and a message about unreadable sources."""
        assert self._scene is not None
        scene, files = self._scene
        found, unknown = spawnables(files, scene.folder, request.sources)
        for uri, description in found:
            spawnable = DEFINITIONS.initial("simulation_interfaces/msg/Spawnable")
            spawnable.uri, spawnable.description = uri, description
            response.spawnables.append(spawnable)
        if unknown:
            names = ", ".join(source[:200] for source in unknown[:20])
            response.result.error_message = f"not folders that may be read: {names}"

    def get_current_world(self, session: SessionCore, request: Any, response: Any) -> None:
        """Answer GetCurrentWorld with the name, the description and the world file of the scene."""
        assert self._scene is not None
        spec = self._scene[0].spec
        response.world.name = spec.scene
        response.world.description = spec.doc
        response.world.world_resource.uri = spec.world

    def _spawn(self, session: SessionCore, request: Any, uri: str, text: str) -> tuple[str, str]:
        """Spawn an entity; return the entity's name and a warning, which is empty if the entity overlaps no other entity."""
        assert self._scene is not None
        scene, files = self._scene
        use = use_of(files, scene.folder, uri, text)
        name = _free_name(session, request.name or name_of(use), allow_renaming=request.allow_renaming)
        position, orientation = pose_in_world(session, request.initial_pose, _INVALID_POSE)
        try:
            turned, namespace = Orientation(quaternion_xyzw=orientation), _namespace(request.entity_namespace)
            robot = RobotUse(use=use, position=position, orientation=turned, namespace=namespace)
        except ValidationError as error:
            raise RefusedError(_NAMESPACE_INVALID, error.errors()[0]["msg"].removeprefix("Value error, ")) from None
        try:
            return name, "".join(Spawn(name=name, use=robot).apply(session)["warnings"])
        except CheckError as error:
            missing = any(finding.code == "S101" for finding in error.findings)
            raise RefusedError(_MISSING_ASSETS if missing else _PARSE_ERROR, str(error)) from error
        except (PhysicsError, BlockedPoseError) as error:
            raise RefusedError(_INVALID_POSE, str(error)) from error


def _free_name(session: SessionCore, wanted: str, *, allow_renaming: bool) -> str:
    """Return the wanted name; if it is in use and renaming is allowed, the name with a number appended.

    Raises:
        RefusedError: the name is invalid, missing or in use.
    """
    if not wanted and not allow_renaming:
        raise RefusedError(_NAME_INVALID, "the resource contains no name: give a name, or allow renaming")
    name = wanted or "entity"
    if _NAME.fullmatch(name) is None:
        legal = "use letters, digits and '_', but no leading digit"
        raise RefusedError(_NAME_INVALID, f"{name[:200]!r} is not a valid name: {legal}")
    taken = {entity.name for entity in session.services.world.entities.all()}
    taken |= {prim.name for prim in session.services.stage.root.children.values()}
    if name not in taken:
        return name
    if not allow_renaming:
        raise RefusedError(_NAME_NOT_UNIQUE, f"the name {name!r} is taken")
    return next(free for number in itertools.count(1) if (free := f"{name[:190]}_{number}") not in taken)


def _namespace(wanted: str) -> str | None:
    """Check and return a requested namespace; None if it is empty, which means the namespace of the robot file."""
    if "{" in wanted:
        raise RefusedError(_NAMESPACE_INVALID, f"{wanted[:200]!r} is not a ROS 2 namespace")
    return wanted or None
