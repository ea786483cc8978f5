"""Texts (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from graphengine.node import In, Node, Numbered, Out
from graphengine.types import PortType, String
from nodes.data.sequences import MAX_LENGTH

TEXTS = "string|token|token[]"


def appended(texts: str | tuple[str, ...], suffix: str | tuple[str, ...]) -> str | tuple[str, ...]:
    """A text after a text; after each text of several the same one, or the one at its place.

    Raises:
        ValueError: there is no telling which goes where, or it is too long.
    """
    if isinstance(texts, str):
        if isinstance(suffix, str):
            if len(texts) + len(suffix) > MAX_LENGTH:
                raise ValueError(f"a text of {len(texts) + len(suffix)} letters is too long; {MAX_LENGTH} are the most")
            return texts + suffix
        raise ValueError(f"{len(suffix)} texts cannot be appended to one")
    if isinstance(suffix, str):
        return tuple(str(appended(text, suffix)) for text in texts)
    if len(texts) != len(suffix):
        raise ValueError(f"{len(suffix)} texts cannot be appended to {len(texts)}; give as many, or one")
    return tuple(str(appended(text, other)) for text, other in zip(texts, suffix, strict=True))


class BuildString(Node, type="omni.graph.nodes.BuildString"):
    """Texts one after the other; Isaac's menu says Append String."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=TEXTS)}

    a: Any = In(type=TEXTS, required=True, doc="comes first; if it is token[], what follows is appended to each")
    b: Any = In(type=TEXTS, required=True, doc="comes next; input2 and so on are there when a file names them")
    value: Any = Out(type=TEXTS, doc="of the type of a")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """That of a."""
        return {"value": known["a"]} if "a" in known else {}

    def compute(self) -> None:
        """Append.

        Raises:
            ValueError: numbers of texts differ.
        """
        value = self.a
        for name in ("b", *self.series["input"]):
            value = appended(value, getattr(self, name))
        self.value = value


class AppendString(Node, type="omni.graph.nodes.AppendString"):
    """A text with another one behind it; an older type than BuildString."""

    value_in: Any = In(
        type=TEXTS, name="value", required=True, doc="comes first; if it is token[], suffix is appended to each"
    )
    suffix: Any = In(type=TEXTS, required=True, doc="comes next")
    value_out: Any = Out(type=TEXTS, name="value", doc="of the type of the input")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """That of the input."""
        return {"value_out": known["value_in"]} if "value_in" in known else {}

    def compute(self) -> None:
        """Append.

        Raises:
            ValueError: numbers of texts differ.
        """
        self.value_out = appended(self.value_in, self.suffix)


class StartsWith(Node, type="omni.graph.nodes.StartsWith"):
    """Whether a text begins with another."""

    prefix: String = In(default="", doc="what it may begin with; every text begins with nothing")
    value: String = In(default="", doc="the text")
    is_prefix: bool = Out()

    def compute(self) -> None:
        """Compare."""
        self.is_prefix = self.value.startswith(self.prefix)


class EndsWith(Node, type="omni.graph.nodes.EndsWith"):
    """Whether a text ends with another."""

    suffix: String = In(default="", doc="what it may end with; every text ends with nothing")
    value: String = In(default="", doc="the text")
    is_suffix: bool = Out()

    def compute(self) -> None:
        """Compare."""
        self.is_suffix = self.value.endswith(self.suffix)
