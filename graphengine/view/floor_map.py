"""Makes the occupancy map of a scene in a background thread, when a viewer first shows the map."""

from __future__ import annotations

import threading
from collections.abc import Callable

from graphengine.format.errors import GraphError
from graphengine.view.layer_data import FloorMap


class FloorMaker:
    """Makes an occupancy map once, in a thread.

    Args:
        make: makes the map, which takes from 0.1 s to some seconds.

    Attributes:
        error: reason why the map could not be made; empty without an error.
    """

    def __init__(self, make: Callable[[], FloorMap]) -> None:
        self._make = make
        self._made: FloorMap | None = None
        self._thread: threading.Thread | None = None
        self.error = ""

    def take(self) -> FloorMap | None:
        """Return the map once, in the first call after it is ready, otherwise None. The thread starts at the first call."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="floor map", daemon=True)
            self._thread.start()
        made, self._made = self._made, None
        return made

    def _run(self) -> None:
        try:
            self._made = self._make()
        except (GraphError, MemoryError) as error:
            self.error = str(error) or "not enough memory for the map"
