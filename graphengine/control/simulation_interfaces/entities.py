"""Handles requests to find and delete entities, and to get and set states and infos of entities."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from graphengine.control.simulation_interfaces import filters
from graphengine.control.simulation_interfaces.results import FAILED, RefusedError
from graphengine.devices.entity import Entity, EntityKind, EntityState
from graphengine.devices.rotation import Pose, Quaternion, Vector3, compose
from graphengine.format.errors import BlockedPoseError, UnknownEntityError
from graphengine.format.spec import Orientation
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.runtime.entity_commands import Delete, Move
from graphengine.runtime.session_core import SessionCore

WORLD = "world"
INVALID_POSE_OF_STATE = 101
FARTHEST = 1e6
"""Maximum absolute value of a coordinate of a position, m."""
_TOLERANCE = 0.01
"""Maximum difference between a quaternion's norm and 1, as in tf2."""
_CATEGORIES: Mapping[EntityKind, int] = {"object": 0, "robot": 1, "mover": 4, "static": 5}
_KNOWN_CATEGORIES = (0, 1, 2, 4, 5)


def get_entities(session: SessionCore, request: Any, response: Any) -> None:
    """Answer GetEntities with the names of the entities that match the filters."""
    response.entities = [entity.name for entity in _matching(session, request.filters)]


def get_entities_states(session: SessionCore, request: Any, response: Any) -> None:
    """Answer GetEntitiesStates with the names and states of the entities that match the filters."""
    get_entities(session, request, response)
    response.states = [_state(session, name) for name in response.entities]


def get_entity_state(session: SessionCore, request: Any, response: Any) -> None:
    """Answer GetEntityState with pose, velocity and acceleration of an entity in the world frame."""
    response.state = _state(session, request.entity)


def set_entity_state(session: SessionCore, request: Any, response: Any) -> None:
    """Answer SetEntityState: move an entity unless it would overlap others; ignore accelerations."""
    entity, state = _entity(session, request.entity), request.state
    if state.header.frame_id not in ("", WORLD):
        raise RefusedError(FAILED, f"a state must be in the frame {WORLD!r}, not {state.header.frame_id!r}")
    position, orientation = plain_pose(state.pose, INVALID_POSE_OF_STATE)
    linear, angular = (_vector(vector) for vector in (state.twist.linear, state.twist.angular))
    asked = (*linear, *angular, *_vector(state.acceleration.linear), *_vector(state.acceleration.angular))
    if entity.kind == "static" and any(asked):
        raise RefusedError(FAILED, f"{entity.name} is fixed to the world and cannot have a velocity or acceleration")
    turned = Orientation(quaternion_xyzw=orientation)
    # Without validation: physics reports a velocity that is not finite, with the name of the entity.
    move = Move.model_construct(
        entity=entity.name, position=position, orientation=turned, linear=linear, angular=angular
    )
    try:
        response.result.error_message = "".join(move.apply(session)["warnings"])
    except BlockedPoseError as error:
        raise RefusedError(INVALID_POSE_OF_STATE, str(error)) from error


def delete_entity(session: SessionCore, request: Any, response: Any) -> None:
    """Answer DeleteEntity: remove a robot; entities of the world file cannot be deleted."""
    entity = _entity(session, request.entity)
    if session.services.stage.find(entity.prim_path).kind != "robot":
        why = "is part of the world file: only robots of the scene can be deleted"
        raise RefusedError(FAILED, f"{entity.name} {why}")
    Delete(name=entity.name).apply(session)


def get_entity_info(session: SessionCore, request: Any, response: Any) -> None:
    """Answer GetEntityInfo with the info that a client has set, or else with an info that has only a category."""
    response.info = _info(session, _entity(session, request.entity))


def set_entity_info(session: SessionCore, request: Any, response: Any) -> None:
    """Answer SetEntityInfo: store the info as long as the entity exists."""
    if request.info.category.category not in _KNOWN_CATEGORIES:
        legal = ", ".join(map(str, _KNOWN_CATEGORIES))
        raise RefusedError(FAILED, f"unknown category {request.info.category.category}; legal: {legal}")
    prim = session.services.stage.find(_entity(session, request.entity).prim_path)
    prim.facts["entity_info"] = request.info


def get_entity_bounds(session: SessionCore, request: Any, response: Any) -> None:
    """Answer GetEntityBounds with a box in the entity's frame; without finite geometry, with empty bounds."""
    box = session.services.world.entities.bounds(_entity(session, request.entity).name, own=True)
    if box is not None:
        response.bounds.type = filters.BOX
        response.bounds.points = [messages.Vector3(*box.high), messages.Vector3(*box.low)]


def pose_in_world(session: SessionCore, stamped: Any, invalid: int) -> Pose:
    """Return the pose of a PoseStamped in the world frame.

    Args:
        session: session with the entities.
        stamped: message whose frame is the name of an entity, `world`, or empty, which means `world`.
        invalid: result code of the error.

    Raises:
        RefusedError: the frame or the pose is invalid.
    """
    pose, frame = plain_pose(stamped.pose, invalid), stamped.header.frame_id
    if frame in ("", WORLD):
        return pose
    try:
        there = session.services.world.entities.state(frame)
    except UnknownEntityError:
        raise RefusedError(invalid, f"unknown frame {frame!r}; legal: {WORLD!r} and the names of entities") from None
    return compose((there.position, there.orientation), pose)


def plain_pose(pose: Any, invalid: int) -> Pose:
    """Return position and orientation of a Pose message.

    Args:
        pose: message.
        invalid: result code of the error.

    Raises:
        RefusedError: a coordinate is too large or not finite, or the quaternion does not have length 1.
    """
    position, turn = _vector(pose.position), pose.orientation
    orientation: Quaternion = (turn.x, turn.y, turn.z, turn.w)
    if not all(abs(value) <= FARTHEST for value in position):
        raise RefusedError(invalid, f"invalid position {position}; coordinates are at most {FARTHEST:g} m")
    if not abs(math.hypot(*orientation) - 1.0) <= _TOLERANCE:
        raise RefusedError(invalid, f"the quaternion {orientation} is not of length 1")
    return position, orientation


def _matching(session: SessionCore, wanted: Any) -> list[Entity]:
    """Return the entities that match an EntityFilters message, in the order of the world."""
    overlaps = filters.overlap(wanted.bounds)
    entities = {entity.name: entity for entity in session.services.world.entities.all()}
    found = [entities[name] for name in filters.name_filter(wanted.filter, list(entities))]
    categories = {category.category for category in wanted.categories}
    if categories or wanted.tags.tags:
        infos = [_info(session, entity) for entity in found]
        found = [
            entity
            for entity, info in zip(found, infos, strict=True)
            if (not categories or info.category.category in categories) and filters.has_tags(wanted.tags, info.tags)
        ]
    if overlaps is not None:
        boxes = [session.services.world.entities.bounds(entity.name) for entity in found]
        found = [entity for entity, box in zip(found, boxes, strict=True) if box is not None and overlaps(box)]
    return found


def _entity(session: SessionCore, name: str) -> Entity:
    """Return the entity with this name or prim path.

    Raises:
        UnknownEntityError: no entity has the name or prim path.
    """
    for entity in session.services.world.entities.all():
        if name in (entity.name, entity.prim_path):
            return entity
    session.services.world.entities.state(name)  # raises an error with similar names
    raise UnknownEntityError(f"no entity {name!r}")


def _info(session: SessionCore, entity: Entity) -> Any:
    """Return the EntityInfo that a client has set, or else an EntityInfo with only a category."""
    given = session.services.stage.find(entity.prim_path).facts.get("entity_info")
    if given is not None:
        return given
    info = DEFINITIONS.initial("simulation_interfaces/msg/EntityInfo")
    info.category.category = _CATEGORIES[entity.kind]
    return info


def _state(session: SessionCore, name: str) -> Any:
    """Return an EntityState message with pose, velocity and acceleration of an entity in the world frame."""
    state: EntityState = session.services.world.entities.state(name)
    message = DEFINITIONS.initial("simulation_interfaces/msg/EntityState")
    message.header = messages.header(session.time, WORLD)
    message.pose = messages.Pose(messages.Point(*state.position), messages.Quaternion(*state.orientation))
    message.twist.linear = messages.Vector3(*state.linear_velocity)
    message.twist.angular = messages.Vector3(*state.angular_velocity)
    message.acceleration.linear = messages.Vector3(*state.linear_acceleration)
    message.acceleration.angular = messages.Vector3(*state.angular_acceleration)
    return message


def _vector(message: Any) -> Vector3:
    return message.x, message.y, message.z
