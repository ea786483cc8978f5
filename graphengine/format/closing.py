"""The base class of objects that a `with` block closes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Self


class Closing(ABC):
    """An object that uses resources until `close` is called. A `with` block calls `close` at its end."""

    @abstractmethod
    def close(self) -> None:
        """Release the resources of the object, such as files, threads or connections."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
