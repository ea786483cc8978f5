"""The UDP ports and the multicast group of a DDS domain, and checks whether this machine can use them."""

from __future__ import annotations

import socket
import struct
from pathlib import Path

_FIRST, _OF_A_DOMAIN, _FIRST_OF_A_PROCESS = 7400, 250, 10
"""RTPS: first port of domain 0, distance between domains, and offset of the first pair of ports of a process."""
MAX_PARTICIPANT_INDEX = 32
"""Maximum index of a process in a domain on one machine, counted from 0; rmw_cyclonedds_cpp has the same maximum."""
_GROUP = "239.255.0.1"
"""Multicast group in which participants discover each other."""


def shared_port(domain_id: int) -> int:
    """Return the port on which all processes of a domain receive multicast for discovery."""
    return _FIRST + _OF_A_DOMAIN * domain_id


def process_ports(domain_id: int) -> list[tuple[int, int]]:
    """Return the pairs of ports for the processes of a domain; each process uses one pair."""
    first = shared_port(domain_id) + _FIRST_OF_A_PROCESS
    return [(port, port + 1) for port in range(first, first + 2 * (MAX_PARTICIPANT_INDEX + 1), 2)]


def can_bind(port: int, *, reuse: bool = False) -> bool:
    """Return whether a UDP port can be bound; with `reuse`, several processes may bind the port, as on DDS's shared port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        if reuse:
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        try:
            bound.bind(("", port))
        except OSError:
            return False
    return True


def has_multicast() -> bool:
    """Return whether a network interface can join DDS's multicast group."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as joining:
        group = struct.pack("=4sI", socket.inet_aton(_GROUP), socket.INADDR_ANY)
        try:
            joining.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
        except OSError:
            return False
    return True


def ephemeral_ports(first: int, last: int) -> str:
    """Return Linux's range of ephemeral ports if it overlaps with the ports from `first` to `last`; else an empty text."""
    try:
        low, high = map(int, Path("/proc/sys/net/ipv4/ip_local_port_range").read_text("ascii").split())
    except (OSError, ValueError):
        return ""
    return f"{low} to {high}" if low <= last and first <= high else ""
