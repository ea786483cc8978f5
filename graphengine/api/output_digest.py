"""The digest of the messages that the nodes of a session publish."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from graphengine.messages.endpoints import EndpointClaim
from graphengine.ros.network import LiveNetwork


class OutputDigest:
    """The BLAKE2b digest of the topic and bytes of each message that nodes publish, in order.

    Attributes:
        messages: number of messages so far.
    """

    def __init__(self, network: LiveNetwork) -> None:
        self._hash = hashlib.blake2b(digest_size=16)
        self._network = network
        self.messages = 0
        network.tap(self)

    @property
    def value(self) -> str:
        """Digest of the messages so far, 32 hexadecimal digits."""
        return self._hash.hexdigest()

    def close(self) -> None:
        """End the digest; its value stays. Safe to call twice."""
        if self in self._network.taps:
            self._network.untap(self)

    def write(self, claim: EndpointClaim, data: bytes) -> None:
        """Add a message."""
        self.messages += 1
        # With their lengths, no two sequences of messages are the same bytes.
        self._hash.update(b"%s\0%d\0%s" % (claim.topic.encode(), len(data), data))

    def deliver(self, claim: EndpointClaim, arrived: Sequence[bytes]) -> None:
        """Ignore messages that nodes receive."""
