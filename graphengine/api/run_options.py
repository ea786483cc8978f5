"""Options of a session, which callers of `Scene.session` and users of `graphrun run` set."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graphengine.format.errors import NodeError, UsageError
from graphengine.format.scene_spec import LockstepSpec, LockstepSpecs
from graphengine.format.spec import Spec
from graphengine.format.spec_reader import read_given
from graphengine.ros.transport import JoinOptions, Transport
from graphengine.scene.loaded_scene import BadValues

Log = Callable[[str, str, str], None]
"""Type of a function that receives the log messages of nodes. Its arguments are severity, prim path of the node, and text."""

_LEVELS = {"error": logging.ERROR, "warning": logging.WARNING}


def log_to_logging(severity: str, node: str, text: str) -> None:
    """Send a node's log message to the Python logger `graphengine`."""
    message = f"{node}: {text}" if node else text
    logging.getLogger("graphengine").log(_LEVELS.get(severity, logging.INFO), "%s", message)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """Options of a session: the arguments of `Scene.session`, and the following options, which only the command line sets.

    Attributes:
        complain: function called with each problem with another ROS 2 participant; None logs the problems as warnings.
        environ: environment variables, such as ROS_DOMAIN_ID and the variables that configure ROS 2 discovery.
        fault: function called with each NodeError if `keep_going` is set; None logs the errors.
        foxglove: host and port on which to start a Foxglove server; None starts no server.
        foxglove_publish: whether Foxglove clients that have the token of the server's address may publish.
        join: function that joins a ROS 2 domain and returns a transport; used instead of `transport`.
        patient: whether DDS writers wait for slow readers.
        parameters: whether the session offers ROS parameters; only transports with a ROS node can.
        lockstep: topics on which the run waits for programs; None takes those of the scene file.
        edit: whether commands may change the files of the session, as `graphrun ctl save` does.
        ports: addresses of ports whose values are recorded and served to Foxglove; their parts may be globs.
        seed: seed of all random generators; None takes the seed with which the scene was loaded.
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
    foxglove_publish: bool = False
    parameters: bool = True
    lockstep: Sequence[LockstepSpec] | None = None
    ports: Sequence[str] = ()
    edit: bool = False


class _Lockstep(Spec):
    lockstep: LockstepSpecs


def read_lockstep(given: Any) -> Sequence[LockstepSpec]:
    """Return the entries of the option `lockstep`, from a mapping or a list of mappings with JSON types.

    Raises:
        UsageError: the entries are invalid.
    """
    return read_given(_Lockstep, "lockstep", {"lockstep": given}).lockstep


def check_recording(path: Path, *, force: bool) -> None:
    """Check that a recording can be written to this path.

    Raises:
        UsageError: the name does not end in `.mcap`, its folder does not exist, or the file exists and `force` is not set.
    """
    if path.suffix != ".mcap" or not path.parent.is_dir() or path.is_dir():
        raise UsageError(f"{path}: expected a file name that ends in .mcap, in an existing folder, such as out.mcap")
    if path.exists() and not force:
        raise UsageError(f"{path}: already exists; --force overwrites it")
