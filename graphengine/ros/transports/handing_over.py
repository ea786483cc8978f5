"""What arrives is handed over in a transport's own thread, which outlives whoever takes it."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

_log = logging.getLogger(__name__)


class HandingOver:
    """Hands messages of one topic or service over; that one could not be taken is logged, the first time.

    Args:
        name: of the topic or the service.
    """

    __slots__ = ("_failed", "_name")

    def __init__(self, name: str) -> None:
        self._name = name
        self._failed = False

    def __call__(self, take: Callable[..., None], *message: Any) -> None:
        """Let somebody take a message."""
        try:
            take(*message)
        except Exception:
            if not self._failed:
                _log.exception("%s: a message could not be delivered; told once", self._name)
            self._failed = True
