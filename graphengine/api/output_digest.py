"""The digest of the messages that the nodes of a session publish."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from graphengine.messages.endpoints import EndpointClaim, Sink
from graphengine.ros.network import LiveNetwork


class OutputDigest:
    """The BLAKE2b digest of the topic and bytes of each message that nodes publish, in order.

    Args:
        network: network of the session.
        everything: whether nodes publish on all topics.

    Attributes:
        messages: number of messages so far.
    """

    def __init__(self, network: LiveNetwork, everything: bool) -> None:
        self._hash = hashlib.blake2b(digest_size=16)
        self._among: list[Sink] = network.sinks if everything else network.taps
        self._among.append(self)
        self.messages = 0

    @property
    def value(self) -> str:
        """Digest of the messages so far, 32 hexadecimal digits."""
        return self._hash.hexdigest()

    def close(self) -> None:
        """End the digest; its value stays. Safe to call twice."""
        if self in self._among:
            self._among.remove(self)

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Add a message."""
        self.messages += 1
        # The lengths make the hashed bytes of different sequences of messages different.
        self._hash.update(b"%s\0%d\0%s" % (claim.topic.encode(), len(data), data))

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Ignore messages that nodes receive."""
