"""Stores the inputs of each recorded tick, so that ticks can be replayed again in any order."""

from __future__ import annotations

import pickle
import tempfile
from array import array

from graphengine.recording.reader import Tick


class TickInputs:
    """The inputs of ticks in a temporary file, because hours of laser scans may not fit into memory."""

    def __init__(self) -> None:
        self._file = tempfile.TemporaryFile()  # noqa: SIM115  # closed by `close`
        self._places = array("Q", [0])
        self._wall_time = 0.0

    def append(self, tick: Tick) -> None:
        """Add the next tick; a tick without wall clock time gets the time of the last tick with a time."""
        self._wall_time = self._wall_time if tick.wall_time is None else tick.wall_time
        self._file.seek(self._places[-1])
        pickle.dump((tick.delivered, tick.commands, self._wall_time, tick.whole), self._file)
        self._places.append(self._file.tell())

    def __getitem__(self, number: int) -> Tick:
        """Return the tick with a number, counted from 1, with inputs but without sent messages."""
        self._file.seek(self._places[number - 1])
        delivered, commands, wall_time, whole = pickle.load(self._file)  # only `append` writes this file
        return Tick(number, delivered=delivered, commands=commands, wall_time=wall_time, whole=whole)

    def close(self) -> None:
        """Delete the temporary file."""
        self._file.close()
