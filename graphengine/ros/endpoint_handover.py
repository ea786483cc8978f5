"""Hands open endpoints over to the nodes that replace their users, so that peers keep them and messages in flight arrive."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from graphengine.messages.endpoints import EndpointClaim


class HeldEndpoint:
    """An endpoint that stays open until every node that holds it has closed it."""

    opened_as: EndpointClaim
    """The claim that it was opened for."""
    holders = 1

    def release(self) -> bool:
        """Give the endpoint up for one holder; return whether it was the last one."""
        self.holders -= 1
        return self.holders <= 0


E = TypeVar("E", bound=HeldEndpoint)


class Handover:
    """The endpoints that are open when nodes begin to be replaced.

    Args:
        ends: open endpoints, each of which is handed over once at most.
    """

    def __init__(self, ends: Iterable[HeldEndpoint]) -> None:
        self._ends = list(ends)

    def take(self, kind: type[E], claim: EndpointClaim) -> E | None:
        """The open endpoint of an equal claim, with one more holder; None if there is none."""
        wanted = _essence(claim)
        for end in self._ends:
            if isinstance(end, kind) and _essence(end.opened_as) == wanted:
                self._ends.remove(end)
                end.holders += 1
                return end
        return None


def _essence(claim: EndpointClaim) -> object:
    """The part of a claim that its endpoint depends on."""
    kinds = claim.direction, claim.message_type, claim.alternatives
    return kinds, claim.node, claim.topic, claim.qos, claim.ros_context
