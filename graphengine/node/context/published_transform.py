"""Reads transforms directly from the publishers of the same session, without the network."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

from graphengine.messages.endpoints import EndpointClaim, Publisher
from graphengine.node.context.session_services import Services


class PublishedTransform:
    """Reads the newest transform between a parent frame and one of several child frames.

    The transform is taken from the messages of the session's own publishers.

    Args:
        services: services of the session.
        beside: description of an endpoint; only publishers with the topic and ROS domain of this endpoint are read.
        parent: published name of the parent frame.
        children: published names of the child frames; a transform to any of them is used.
    """

    def __init__(self, services: Services, beside: EndpointClaim, parent: str, children: Collection[str]) -> None:
        self._services = services
        self._beside = beside
        self._parent = parent
        self._children = children
        self._source: Publisher | None = None
        self._seen: Any = None

    def newest(self) -> Any | None:
        """Return the newest geometry_msgs/TransformStamped; None if no message was published since the last call."""
        message = self._source.latest if self._source is not None else None
        if message is self._seen:  # no new message: the publisher may have been replaced
            self._source = next(filter(self._has_it, self._services.network.publishers), None)
            message = self._source.latest if self._source is not None else None
        if message is self._seen:
            return None
        self._seen = message
        return next(filter(self._is_it, message.transforms if message is not None else ()), None)

    def _is_it(self, edge: Any) -> bool:
        return edge.header.frame_id == self._parent and edge.child_frame_id in self._children

    def _has_it(self, publisher: Publisher) -> bool:
        claim, beside, domain = publisher.claim, self._beside, self._services.domain
        same_topic = claim.topic == beside.topic and domain(claim.ros_context) == domain(beside.ros_context)
        return same_topic and has_transform([claim], self._parent, self._children)


def has_transform(claims: Iterable[EndpointClaim], parent: str, children: Collection[str]) -> bool:
    """Return whether an endpoint described in `claims` publishes a transform from the parent frame to one of the child frames."""
    return any(above == parent and child in children for claim in claims for above, child in claim.transforms)
