"""The ROS 2 domain and the discovery range of a transport; both determine which peers the transport can reach."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, cast, get_args

from graphengine.format.errors import TransportError
from graphengine.format.wording import did_you_mean, listing

DiscoveryRange = Literal["SUBNET", "LOCALHOST", "OFF", "SYSTEM_DEFAULT"]

MAX_DOMAIN_ID = 232
"""Largest domain id: the UDP ports of a domain start at 7400 + 250 * id, and port numbers end at 65535."""


@dataclass(frozen=True, slots=True)
class Domain:
    """A ROS 2 domain with the discovery settings of one process.

    Args:
        id: domain id; participants with different ids do not discover each other.
        discovery_range: range of discovery; OFF finds no peers outside this process.
        static_peers: additional hosts for discovery; without effect for OFF and SYSTEM_DEFAULT.
        cyclone_uri: the user's Cyclone DDS configuration; overrides the built-in configuration.

    Raises:
        TransportError: the domain id is not legal.
    """

    id: int = 0
    discovery_range: DiscoveryRange = "SUBNET"
    static_peers: tuple[str, ...] = ()
    cyclone_uri: str = ""

    def __post_init__(self) -> None:
        if not 0 <= self.id <= MAX_DOMAIN_ID:
            raise TransportError(f"ROS domain id {self.id} is out of range; legal: 0 to {MAX_DOMAIN_ID}")

    def __str__(self) -> str:
        own = ", with CYCLONEDDS_URI" if self.cyclone_uri else ""
        return f"domain {self.id}, discovery range {self.discovery_range}{own}"

    @classmethod
    def from_environment(cls, environ: Mapping[str, str]) -> Domain:
        """Return the domain that ROS 2 programs with the given environment variables use.

        ROS 2 replaces an unknown discovery range or a malformed ROS_LOCALHOST_ONLY with the default value. Here both are
        errors, because with the default value a typo might hide the robot from other programs.

        Raises:
            TransportError: a variable has an illegal value.
        """
        alone = environ.get("ROS_LOCALHOST_ONLY", "")
        if alone not in ("", "0", "1"):
            raise TransportError(f"ROS_LOCALHOST_ONLY is {alone!r}\nlegal: 0, 1")
        number, uri = _domain_id(environ.get("ROS_DOMAIN_ID", "")), environ.get("CYCLONEDDS_URI", "")
        if alone == "1":
            return cls(number, "LOCALHOST", (), uri)
        peers = tuple(peer for peer in environ.get("ROS_STATIC_PEERS", "").split(";") if peer)
        return cls(number, _range(environ.get("ROS_AUTOMATIC_DISCOVERY_RANGE", "")), peers, uri)


def _domain_id(text: str) -> int:
    try:
        number = int(text, 0) if text else 0
    except ValueError:
        number = -1
    if not 0 <= number <= MAX_DOMAIN_ID:
        raise TransportError(f"ROS_DOMAIN_ID is {text!r}\nlegal: a whole number from 0 to {MAX_DOMAIN_ID}")
    return number


def _range(text: str) -> DiscoveryRange:
    legal = get_args(DiscoveryRange)
    if text not in ("", *legal):
        lines = (f"ROS_AUTOMATIC_DISCOVERY_RANGE is {text!r}", did_you_mean(text, legal), listing(legal))
        raise TransportError("\n".join(filter(None, lines)))
    return cast(DiscoveryRange, text or "SUBNET")
