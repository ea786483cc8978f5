"""Hands open endpoints over to the nodes of changed graphs, so that peers stay matched and no message is lost."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from graphengine.messages.endpoints import EndpointClaim


class HeldEndpoint:
    """An endpoint that stays open until every node that holds it has closed it."""

    opened_as: EndpointClaim
    """Claim for which the endpoint was opened."""
    holders = 1

    def release(self) -> bool:
        """Remove one holder of the endpoint; return whether it was the last one."""
        self.holders -= 1
        return self.holders <= 0


E = TypeVar("E", bound=HeldEndpoint)


class Handover:
    """The endpoints that are open when an exchange of nodes begins.

    Args:
        ends: open endpoints; each is handed over at most once.
    """

    def __init__(self, ends: Iterable[HeldEndpoint]) -> None:
        self._ends = list(ends)

    def take(self, kind: type[E], claim: EndpointClaim) -> E | None:
        """Return the open endpoint of an equal claim and add a holder, or return None."""
        wanted = _essence(claim)
        for end in self._ends:
            if isinstance(end, kind) and _essence(end.opened_as) == wanted:
                self._ends.remove(end)
                end.holders += 1
                return end
        return None


def _essence(claim: EndpointClaim) -> object:
    """Return the part of a claim on which its endpoint depends."""
    kinds = claim.direction, claim.message_type, claim.alternatives
    return kinds, claim.node, claim.topic, claim.qos, claim.ros_context
