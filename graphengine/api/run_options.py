"""Options of a session: what a caller of `Scene.session` or `graphrun run` may choose."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from graphengine.format.errors import NodeError, UsageError
from graphengine.node.dropped_values import BadValues
from graphengine.ros.transport import JoinOptions, Transport

Log = Callable[[str, str, str], None]
"""Function that receives the messages of nodes. Its arguments are severity, prim path of the node, and text."""

_LEVELS = {"error": logging.ERROR, "warning": logging.WARNING}


def log_to_logging(severity: str, node: str, text: str) -> None:
    """Send a node's message to the Python logger `graphengine`."""
    message = f"{node}: {text}" if node else text
    logging.getLogger("graphengine").log(_LEVELS.get(severity, logging.INFO), "%s", message)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """Options of a session: the arguments of `Scene.session`, and those that only the command line sets.

    Attributes:
        complain: receives each problem with a peer on the network; None logs them.
        environ: environment variables; those of ROS 2 set the domain and the range of discovery.
        fault: receives each NodeError if `keep_going` is set; None logs them.
        foxglove: host and port of a server for Foxglove; None for no server.
        join: function that joins a ROS 2 domain; replaces `transport`.
        patient: DDS writers wait for slow readers.
        parameters: offer ROS parameters, on transports with a node.
        seed: seed of all random generators; None takes the scene's.
    """

    transport: str = "memory"
    seed: int | None = None
    keep_going: bool = False
    bad_values: BadValues = "drop"
    domain: int | None = None
    record: Path | None = None
    force: bool = False
    control: str | None = None
    simulation_interfaces: str | None = None
    log: Log = log_to_logging
    complain: Callable[[str], None] | None = None
    environ: Mapping[str, str] = field(default_factory=lambda: os.environ)
    fault: Callable[[NodeError], None] | None = None
    join: Callable[[JoinOptions], Transport] | None = None
    patient: bool = False
    foxglove: tuple[str, int] | None = None
    parameters: bool = True


def check_recording(path: Path, *, force: bool) -> None:
    """Check that a recording can be written under this name.

    Raises:
        UsageError: the name does not end in `.mcap`, its folder does not exist, or the file exists and `force` is not set.
    """
    if path.suffix != ".mcap" or not path.parent.is_dir() or path.is_dir():
        raise UsageError(f"{path}: write the name of a file in an existing folder, such as out.mcap")
    if path.exists() and not force:
        raise UsageError(f"{path}: already exists; --force overwrites it")
