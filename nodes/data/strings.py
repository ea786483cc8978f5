"""Texts (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from graphengine.node import In, Node, Numbered, Out
from graphengine.types import PortType, String, Token, Tokens
from nodes.data.sequences import MAX_LENGTH, checked_length

TEXTS = "string|token|token[]"


def check_text_length(letters: int) -> None:
    """Refuse a text that is too long.

    Raises:
        ValueError: it is.
    """
    if letters > MAX_LENGTH:
        raise ValueError(f"a text of {letters} letters is too long; {MAX_LENGTH} are the most")


def appended(texts: str | tuple[str, ...], suffix: str | tuple[str, ...]) -> str | tuple[str, ...]:
    """A text after a text; after each text of several the same one, or the one at its place.

    Raises:
        ValueError: there is no telling which goes where, or it is too long.
    """
    if isinstance(texts, str):
        if isinstance(suffix, str):
            check_text_length(len(texts) + len(suffix))
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


_CASES: dict[str, Callable[[str], str]] = {
    "UpperCase": str.upper,
    "LowerCase": str.lower,
    "Capitalize": str.capitalize,
    "Title": lambda text: " ".join(map(str.capitalize, text.split(" "))),
}


class CapitalizeString(Node, type="omni.graph.nodes.CapitalizeString"):
    """A text in capitals or in small letters, whole or but for its first letter, or the first letters of its words."""

    operation: Token = In(default="UpperCase", tokens=tuple(_CASES))
    string_in: Any = In(type=TEXTS, name="string", couple="text", required=True, doc="a text, or several")
    string_out: Any = Out(type=TEXTS, name="string", couple="text", doc="of the type of the input")

    def compute(self) -> None:
        """Write it otherwise.

        Raises:
            ValueError: there is no such operation.
        """
        change = _CASES.get(self.operation)
        if change is None:
            raise ValueError(f"operation is {self.operation!r}; it is one of {', '.join(_CASES)}")
        text = self.string_in
        self.string_out = change(text) if isinstance(text, str) else tuple(map(change, text))


class SplitString(Node, type="omni.graph.nodes.SplitString"):
    """The parts of a text between those places where another text stands."""

    delimiter: String = In(default=" ", doc="the other text")
    string: String = In(default="", doc="is taken apart")
    elements: Tokens = Out(doc="the parts, some of them perhaps empty; none if the text or the delimiter is empty")

    def compute(self) -> None:
        """Take it apart.

        Raises:
            ValueError: the parts are too many.
        """
        parts = self.string.split(self.delimiter) if self.string and self.delimiter else []
        checked_length(len(parts))
        self.elements = tuple(parts)


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
