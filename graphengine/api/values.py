"""Port values of a session, by address."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from graphengine.api.runner import Runner
from graphengine.format.errors import UsageError
from graphengine.format.wording import shown
from graphengine.runtime.addresses import NodePort, find_port_at, find_ports


class Values:
    """Reads port values of a session; looked-up addresses are cached until the graphs change."""

    def __init__(self, runner: Runner) -> None:
        self._runner = runner
        self._graphs: object = None
        self._found: dict[str, NodePort] = {}

    def one(self, address: str) -> Any:
        """The value of one port.

        Raises:
            UsageError: no port has the address, or several have.
        """
        graphs = self._runner.session.graphs
        if self._graphs is not graphs:
            self._graphs, self._found = graphs, {}
        if address not in self._found:
            self._found[address] = find_port_at(graphs, address)
        return read_only(self._found[address].value)

    def matching(self, pattern: str) -> dict[str, Any]:
        """The values of all ports that a pattern matches, by address.

        Raises:
            UsageError: no port matches.
        """
        return {port.address: read_only(port.value) for port in find_ports(self._runner.session.graphs, pattern)}


def read_only(value: Any) -> Any:
    """The value, with arrays as read-only views."""
    if not isinstance(value, np.ndarray):
        return value
    view = value.view()
    view.flags.writeable = False
    return view


def plain(value: Any) -> Any:
    """The value as JSON types, with arrays as lists.

    Raises:
        UsageError: the value cannot be written as JSON.
    """
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if value is None or isinstance(value, bool | int | float | str):
        return value
    raise UsageError(f"expected numbers, texts, booleans and lists of them, got {shown(value)}")
