"""Hands open endpoints over to the nodes of changed graphs, so that peers stay matched and no message is lost."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from graphengine.messages.endpoints import EndpointClaim


class HeldEndpoint:
    """An endpoint that stays open until every node that holds it has closed it."""

    opened_as: EndpointClaim
    """Claim for which the endpoint was created; unlike `claim`, it keeps its type when a subscription switches to another."""
    holders = 1

    def release(self) -> bool:
        """Remove one holder of the endpoint; return whether it was the last one."""
        self.holders -= 1
        return self.holders <= 0


E = TypeVar("E", bound=HeldEndpoint)


class Handover:
    """The open endpoints that the nodes of changed graphs can take over.

    Args:
        ends: open endpoints; each can be taken once.
    """

    def __init__(self, ends: Iterable[HeldEndpoint]) -> None:
        self._ends = list(ends)

    def take(self, kind: type[E], claim: EndpointClaim) -> E | None:
        """Return an open endpoint that was created for an equal claim, and add one holder; None if no endpoint fits."""
        wanted = _essence(claim)
        for end in self._ends:
            if isinstance(end, kind) and _essence(end.opened_as) == wanted:
                self._ends.remove(end)
                end.holders += 1
                return end
        return None


def _essence(claim: EndpointClaim) -> object:
    """Return the fields of a claim that must be equal for a handover: node, topic, types, direction, QoS, context."""
    kinds = claim.direction, claim.message_type, claim.alternatives
    return kinds, claim.node, claim.topic, claim.qos, claim.ros_context
