"""Collects the values of ports after each tick as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graphengine.api.after_tick import AfterTick
from graphengine.api.runner import Runner
from graphengine.runtime.port_values import PortValues


class ValueRecord(AfterTick, Mapping[str, NDArray[Any]]):
    """The values of ports after each tick, as arrays by address of the port; `Session.record_values` creates it.

    The first axis of each array is the tick; an array whose length changes gives an array of objects. After a reload, the record
    ends, because the ports may be others.

    Args:
        runner: runner of the session.
        patterns: addresses of the ports, whose parts may be globs.
    """

    def __init__(self, runner: Runner, patterns: Sequence[str]) -> None:
        self._runner = runner
        self._ports = PortValues(runner.session, patterns).ports
        self._graphs = runner.session.graphs
        self._ticks = runner.session.ticks
        self._times: list[float] = []
        self._values: list[list[Any]] = [[] for _ in self._ports]
        runner.after_ticks[self] = self

    def after_tick(self, frame: int) -> None:
        """Add the present values."""
        session = self._runner.session
        if session.graphs is not self._graphs:
            self.close()
        if (
            session.ticks == self._ticks or session.graphs is not self._graphs
        ):  # called without a tick while the session waits
            return
        self._ticks = session.ticks
        self._times.append(session.time)
        for values, port in zip(self._values, self._ports, strict=True):
            value = port.value
            values.append(value.copy() if isinstance(value, np.ndarray) else value)

    def close(self) -> None:
        """End the record; its values stay. Safe to call twice."""
        self._runner.after_ticks.pop(self, None)

    @property
    def times(self) -> NDArray[np.float64]:
        """Simulation time of each tick, s."""
        return np.array(self._times)

    def __getitem__(self, address: str) -> NDArray[Any]:
        for port, values in zip(self._ports, self._values, strict=True):
            if port.address == address:
                lengths = {np.shape(value) for value in values}
                return np.array(values) if len(lengths) <= 1 else np.array(values, dtype=object)
        raise KeyError(address)

    def __iter__(self) -> Iterator[str]:
        return (port.address for port in self._ports)

    def __len__(self) -> int:
        return len(self._ports)

    def __eq__(self, other: object) -> bool:
        return self is other

    def __hash__(self) -> int:
        return id(self)
