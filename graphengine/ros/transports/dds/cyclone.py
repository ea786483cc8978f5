"""Wraps the Python package of Eclipse Cyclone DDS: joins a domain as ROS 2 does, converts QoS, and moves encoded messages.

Encoded messages need two private functions of the package, `ddspy_write` and `ddspy_take`; so the package's version is pinned.
"""

from __future__ import annotations

import os
import re
import socket
import sys
import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from cyclonedds import _clayer
from cyclonedds.core import DDSException, Entity
from cyclonedds.domain import Domain as DdsDomain
from cyclonedds.domain import DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.util import duration

from graphengine.format.errors import TransportError
from graphengine.format.process_limits import has_address_space, has_descriptors
from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import settled
from graphengine.ros.domain import Domain
from graphengine.ros.ports import MAX_PARTICIPANT_INDEX
from graphengine.ros.transports.dds.cyclone_log import LOG

MAX_BLOCKING_MS = 100
"""Maximum time that a slow reliable reader can block a write, ms."""

DESCRIPTORS, ADDRESS_SPACE = 24, 400_000_000
"""File descriptors, and bytes of address space, that must be free for a participant; measured use: 10 and 390 MB."""

TIMEOUT: int = DDSException.DDS_RETCODE_TIMEOUT

READING_POLICIES = threading.Lock()
"""Lock for reading the QoS policies of a peer, because the package then uses global variables."""

_ANY_STATE = 0x7F
_TYPE_HASH = re.compile(rb"typehash=(RIHS[0-9A-Fa-f_]+);")
_BATCH = 64
_UNLIMITED = -1
_LOOPBACK = "127.0.0.1"
_DATAGRAM = 14720
"""Maximum size of a datagram, bytes: Cyclone's default. A default socket buffer holds only three datagrams of 65500."""
_FRAGMENT = 14600
"""Size of a fragment that fills a datagram, bytes. With Cyclone's default, 1344, repairs need ten times as many datagrams."""


def write(entity: Any, data: bytes) -> int:
    """Send a CDR message with a Cyclone DDS writer; return a negative Cyclone error code on failure."""
    return int(_clayer.ddspy_write(entity._ref, data))


def take(entity: Any) -> list[tuple[bytes, int]]:
    """Remove messages from a reader's queue and return them, oldest first, each with the handle of its writer.

    One call may leave messages in the queue; the list is empty only if the queue is empty.
    """
    while isinstance(samples := _clayer.ddspy_take(entity._ref, _ANY_STATE, _BATCH), list) and samples:
        if messages := [(data, info.publication_handle) for data, info in samples if info.valid_data]:
            return messages
    return []


class Peer(NamedTuple):
    """A matched peer of a reader or writer.

    Args:
        gid: 16 bytes that identify the endpoint in ROS 2.
        user_data: user data that the peer announces.
    """

    gid: bytes
    user_data: bytes

    @property
    def type_hash(self) -> str:
        """Hash of the message type; empty if the peer does not announce one."""
        return type_hash(self.user_data)


def writer_of(reader: Any, handle: int) -> Peer:
    """Return the matched writer with this handle; a peer with an empty GID if the writer is gone."""
    return _peers([handle], reader.get_matched_publication_data).get(unsigned(handle), Peer(b"", b""))


def writers_of(reader: Any) -> dict[int, Peer]:
    """Return each matched writer of a reader, by the writer's handle."""
    return _peers(reader.get_matched_publications(), reader.get_matched_publication_data)


def readers_of(writer: Any) -> dict[int, Peer]:
    """Return each matched reader of a writer, by the reader's handle."""
    return _peers(writer.get_matched_subscriptions(), writer.get_matched_subscription_data)


def _peers(handles: Iterable[int], ask: Callable[[int], Any]) -> dict[int, Peer]:
    with READING_POLICIES:
        told = {handle: data for handle in handles if (data := ask(handle)) is not None}
    return {unsigned(handle): Peer(bytes(data.key.bytes), user_data(data.qos)) for handle, data in told.items()}


def unsigned(handle: int) -> int:
    """Return a handle as an unsigned number, as in received messages; other functions of the package return signed handles."""
    return handle & 0xFFFF_FFFF_FFFF_FFFF


def user_data(policies: Qos) -> bytes:
    """Return the user data in the policies of an endpoint or participant; empty without user data."""
    policy = policies[Policy.Userdata]
    return bytes(policy.data) if policy else b""


def type_hash(data: bytes) -> str:
    """Return the type hash in the user data of an endpoint; empty if the data contain no type hash."""
    found = _TYPE_HASH.search(data)
    return found[1].decode() if found else ""


def delete(entity: Any) -> None:
    """Delete an entity and all its children from the network; safe to call twice."""
    # Python's garbage collector would do this too, but late: a traceback, for example, may keep a reference to the wrapper.
    Entity.__del__(entity)


def reason(code: int) -> str:
    """Return the description of a Cyclone error code."""
    return str(DDSException(code)).strip()


def endpoint_qos(qos: QoS, user_data: str) -> Qos:
    """Return the DDS policies of a writer or reader for a QoS profile, as ROS 2 sets them."""
    qos = settled(qos)
    history = Policy.History.KeepAll if qos.history == "keepAll" else Policy.History.KeepLast(qos.depth)
    reliable = Policy.Reliability.Reliable(duration(milliseconds=MAX_BLOCKING_MS))
    liveliness = Policy.Liveliness.ManualByTopic if qos.liveliness == "manualByTopic" else Policy.Liveliness.Automatic
    lease = duration(seconds=qos.lease_duration) if qos.lease_duration else duration(infinite=True)
    policies = [
        history,
        reliable if qos.reliability == "reliable" else Policy.Reliability.BestEffort,
        liveliness(lease),
        # ROS 2 reads and writes the first version of XCDR only.
        Policy.DataRepresentation(use_cdrv0_representation=True, use_xcdrv2_representation=False),
        # Otherwise a closed writer removes the messages for late joiners, and readers see a disposed instance.
        Policy.WriterDataLifecycle(autodispose=False),
        Policy.Userdata(user_data.encode()),
    ]
    if qos.durability == "transientLocal":
        policies.append(Policy.Durability.TransientLocal)
        # For late joiners, Cyclone keeps as many messages as this policy says, not as the history says.
        policies.append(Policy.DurabilityService(0, history, _UNLIMITED, _UNLIMITED, _UNLIMITED))
    if qos.deadline:
        policies.append(Policy.Deadline(duration(seconds=qos.deadline)))
    if qos.lifespan:
        policies.append(Policy.Lifespan(duration(seconds=qos.lifespan)))
    return Qos(*policies)


def read_qos(policies: Qos) -> QoS:
    """Return the QoS profile for DDS policies; a durability that ROS 2 does not have becomes `systemDefault`."""
    history, reliability = policies[Policy.History], policies[Policy.Reliability]
    deadline, lifespan = policies[Policy.Deadline], policies[Policy.Lifespan]
    liveliness = policies[Policy.Liveliness]
    kept = isinstance(history, Policy.History.KeepLast)
    manual = isinstance(liveliness, Policy.Liveliness.ManualByTopic)
    return QoS(
        history="keepLast" if kept else "keepAll",
        depth=history.depth if kept else 0,
        reliability="reliable" if isinstance(reliability, Policy.Reliability.Reliable) else "bestEffort",
        durability=_DURABILITIES.get(policies[Policy.Durability], "systemDefault"),
        deadline=_seconds(deadline.deadline),
        lifespan=_seconds(lifespan.lifespan) if lifespan else 0.0,  # no policy of readers
        liveliness="manualByTopic" if manual else "automatic",
        lease_duration=_seconds(liveliness.lease_duration),
    )


_DURABILITIES: dict[Any, Literal["volatile", "transientLocal"]] = {
    Policy.Durability.Volatile: "volatile",
    Policy.Durability.TransientLocal: "transientLocal",
}


def _seconds(nanoseconds: int) -> float:
    return 0.0 if nanoseconds == duration(infinite=True) else nanoseconds / 1e9


@dataclass(slots=True)
class _Joined:
    """A DDS domain that this process has joined, with the number of participants; all participants have one configuration."""

    domain: Domain
    entity: Any
    participants: int = 0


_joined: dict[int, _Joined] = {}
_lock = threading.Lock()


def join(domain: Domain, user_data: str) -> Any:
    """Return a new participant in a domain, configured for its discovery range.

    Raises:
        TransportError: Cyclone cannot use the network, too few file descriptors or too little memory are free, or this process
            has joined the domain with another configuration.
    """
    with _lock:
        _require_resources(domain)
        joined = _joined.get(domain.id)
        if joined is None:
            joined = _Joined(domain, _open(domain))
        elif joined.domain != domain:
            raise TransportError(f"this process has already joined {joined.domain}; it cannot also join {domain}")
        try:
            participant = DomainParticipant(domain.id, Qos(Policy.Userdata(user_data.encode())))
        except DDSException as error:
            if not joined.participants:
                delete(joined.entity)
            raise TransportError(f"cannot join {domain}: {error}") from error
        joined.participants += 1
        _joined[domain.id] = joined
        return participant


def _require_resources(domain: Domain) -> None:
    """Raise TransportError if too few file descriptors or too little memory are free; Cyclone would end the process."""
    if not has_descriptors(DESCRIPTORS):
        remedy = "raise the limit of `ulimit -n`"
        raise TransportError(f"cannot join {domain}: it needs {DESCRIPTORS} more open files\n{remedy}")
    if not has_address_space(ADDRESS_SPACE):
        remedy = "raise the limit of `ulimit -v`"
        raise TransportError(f"cannot join {domain}: it needs {ADDRESS_SPACE // 10**6} MB more memory\n{remedy}")


def leave(domain: Domain, participant: Any) -> None:
    """Delete a participant; with the last participant in a domain, Cyclone also closes the domain's sockets and threads."""
    with _lock:
        delete(participant)
        joined = _joined[domain.id]
        joined.participants -= 1
        if not joined.participants:
            delete(joined.entity)
            del _joined[domain.id]
            LOG.forget(domain.id)


def _open(domain: Domain) -> Any:
    errors = []
    for configuration in configurations(domain):
        try:
            with LOG.capture():
                return DdsDomain(domain.id, configuration)
        except DDSException as error:
            errors.append(LOG.reason() or str(error))
    help_lines = "\nis a network interface up?\nto run without a network: --transport memory"
    raise TransportError(f"cannot join {domain}: {errors[-1]}{'' if domain.cyclone_uri else help_lines}")


def configurations(domain: Domain) -> list[str]:
    """Return Cyclone DDS configurations for a domain, in the order in which to try them.

    ROS 2 programs on one host use loopback addresses, which Cyclone ignores unless the configuration has the interface `lo`. If
    `lo` is the only active interface, Cyclone chooses it automatically, and an additional entry for `lo` is an error.
    """
    if domain.cyclone_uri:
        return [f"{_fragment(domain, '')},{domain.cyclone_uri}"]
    if domain.discovery_range == "SYSTEM_DEFAULT":
        return [""]
    loopback = f'<NetworkInterface address="{_LOOPBACK}"{{}}/>'
    if domain.discovery_range == "OFF":
        return [_fragment(domain, loopback.format(""))]
    if {name for _, name in socket.if_nameindex()} == {"lo"}:
        return [_fragment(domain, loopback.format(""))]
    both = '<NetworkInterface autodetermine="true"/>' + loopback.format(' multicast="true"')
    return [_fragment(domain, both), _fragment(domain, loopback.format(""))]


def _fragment(domain: Domain, interfaces: str) -> str:
    """Return a configuration like that of rmw_cyclonedds_cpp for the discovery range, but with larger fragments."""
    if domain.discovery_range == "SYSTEM_DEFAULT":
        return ""
    multicast = "true" if domain.discovery_range == "SUBNET" else "false"
    general = f"<AllowMulticast>{multicast}</AllowMulticast>"
    if sys.platform == "linux":  # other systems refuse such large datagrams by default
        general += f"<FragmentSize>{_FRAGMENT}B</FragmentSize><MaxMessageSize>{_DATAGRAM}B</MaxMessageSize>"
    if interfaces:
        general += f"<Interfaces>{interfaces}</Interfaces>"
    if domain.discovery_range == "OFF":
        # Only participants with the same tag discover each other.
        discovery = f"<ParticipantIndex>none</ParticipantIndex><Tag>ros_discovery_off_{os.getpid()}</Tag>"
    else:
        peers = "".join(f'<Peer address="{address}"/>' for address in (_LOOPBACK, *map(_address, domain.static_peers)))
        discovery = "<ParticipantIndex>auto</ParticipantIndex>"
        discovery += f"<MaxAutoParticipantIndex>{MAX_PARTICIPANT_INDEX}</MaxAutoParticipantIndex><Peers>{peers}</Peers>"
    content = f"<General>{general}</General><Discovery>{discovery}</Discovery>"
    return f'<CycloneDDS><Domain Id="any">{content}</Domain></CycloneDDS>'


def _address(peer: str) -> str:
    """Return the IP address of a host; raise TransportError for an unknown host, for which Cyclone would abort the process."""
    try:
        return socket.gethostbyname(peer)
    except OSError as error:
        raise TransportError(f"ROS_STATIC_PEERS has an unknown host {peer!r}: {error}") from error
