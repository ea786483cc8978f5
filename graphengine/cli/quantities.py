"""Parsers for times, rates, addresses, numbers, angles and vectors on the command line.

Each raises ArgumentTypeError for an illegal text.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable
from contextlib import suppress

from graphengine.format import durations
from graphengine.runtime.pacer import SLOWEST


def duration(text: str) -> float:
    """Parse a time such as `10`, `10s`, `500ms` or `2min` to seconds."""
    try:
        return durations.seconds(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def rate(text: str) -> float:
    """Parse a rate, in seconds of simulation per second of wall time; `realtime` is 1, and `max` is infinity."""
    named = {"realtime": 1.0, "max": math.inf}
    try:
        factor = named[text] if text in named else float(text)
    except ValueError:
        factor = 0.0
    if not factor >= SLOWEST:
        advice = f"write realtime, max or a factor from {SLOWEST} up"
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is not a rate; {advice}")
    return factor


def address(text: str) -> tuple[str, int]:
    """Parse an address such as `8765`, `0.0.0.0:8765` or `[::1]:8765` to host, by default 127.0.0.1, and port."""
    match = re.fullmatch(r"(?:(?:\[([0-9A-Fa-f:.]+)\]|([^][:/\s]+)):)?([0-9]{1,5})", text.strip())
    if match is None or int(match[3]) > 65535:
        advice = "write PORT or HOST:PORT, such as 8765 or 0.0.0.0:8765"
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is not an address; {advice}")
    return match[1] or match[2] or "127.0.0.1", int(match[3])


def port(text: str) -> int:
    """Parse a TCP port, 0 to 65535."""
    if not re.fullmatch("[0-9]{1,5}", text.strip()) or int(text) > 65535:
        advice = "write a number from 0 to 65535, such as 8080"
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is not a port; {advice}")
    return int(text)


def ip_address(text: str) -> str:
    """Parse an IP address of this machine to its canonical text."""
    import ipaddress

    try:
        return str(ipaddress.ip_address(text.strip()))
    except ValueError:
        advice = "write one such as 127.0.0.1, or 0.0.0.0 for all"
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is not an IP address; {advice}") from None


def whole(text: str) -> int:
    """Parse an integer."""
    return int(_number(text, int, -math.inf, "a whole number"))


def number(text: str) -> float:
    """Parse a finite number."""
    return _number(text, float, -sys.float_info.max, "a number")


def seconds(text: str) -> float:
    """Parse a number of seconds, 0 or more."""
    return _number(text, float, 0.0, "seconds, such as 0.5")


def positive(text: str) -> float:
    """Parse a number above 0."""
    return _number(text, float, sys.float_info.min, "a number above 0")


def count(text: str) -> int:
    """Parse an integer of 0 or more."""
    return int(_number(text, int, 0, "a whole number, 0 or more"))


def size(text: str) -> int:
    """Parse an integer of 1 or more."""
    return int(_number(text, int, 1, "a whole number, 1 or more"))


def _number(text: str, kind: Callable[[str], float], least: float, legal: str) -> float:
    with suppress(ValueError):
        if least <= (value := kind(text)) < math.inf:
            return value
    raise argparse.ArgumentTypeError(f"{text.strip()!r}: write {legal}")


def angle(text: str) -> float:
    """Parse an angle such as `1.57`, `1.57rad` or `90deg` to radians."""
    match = re.fullmatch(r"([-+.e0-9]+)(rad|deg|)", text.strip())
    if match is None:
        raise argparse.ArgumentTypeError(f"{text.strip()!r} is not an angle; write 1.57, 1.57rad or 90deg")
    return math.radians(number(match[1])) if match[2] == "deg" else number(match[1])


def target(item: Callable[[str], float]) -> Callable[[str], tuple[str, float]]:
    """Return a parser for a target of a joint, such as `shoulder=0.5`; `item` parses the number."""

    def read(text: str) -> tuple[str, float]:
        name, _, value = text.strip().rpartition("=")
        if not name:
            advice = "write JOINT=NUMBER, such as shoulder=0.5"
            raise argparse.ArgumentTypeError(f"{text.strip()!r} is not a target; {advice}")
        return name, item(value)

    return read


def vector(*sizes: int, item: Callable[[str], float] = number) -> Callable[[str], tuple[float, ...]]:
    """Return a parser for vectors such as `1,2,0`.

    Args:
        sizes: legal numbers of components, such as 2 and 3.
        item: parser for each component.
    """

    def read(text: str) -> tuple[float, ...]:
        parts = text.split(",")
        if len(parts) not in sizes:
            wanted = " or ".join(map(str, sizes))
            advice = f"write {wanted} numbers separated by commas, as in 1,2,0"
            raise argparse.ArgumentTypeError(f"{text.strip()!r}: {advice}")
        return tuple(item(part) for part in parts)

    return read
