"""Texts (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from graphengine.node import BadValueError, In, Node, Numbered, Out, PortType, String, Token, Tokens
from graphengine.nodes.checked import one_of
from graphengine.nodes.data.sequences import MAX_LENGTH, checked_length

TEXTS = "string|token|token[]"


def check_text_length(port: str, letters: int) -> None:
    """Refuse a text, or texts, that `port` makes too long.

    Raises:
        BadValueError: it does.
    """
    if letters > MAX_LENGTH:
        raise BadValueError(port, letters, f"so long that the result has {MAX_LENGTH} letters or fewer")


def appended(port: str, texts: str | tuple[str, ...], suffix: str | tuple[str, ...]) -> str | tuple[str, ...]:
    """A text after a text; after each text of several the same one, or the one at its place.

    Args:
        port: OmniGraph's name of the input of the suffix.
        texts: what comes first.
        suffix: what comes next.

    Raises:
        BadValueError: the suffixes are neither one nor as many as the texts, or the result is too long.
    """
    if isinstance(texts, str):
        if not isinstance(suffix, str):
            raise BadValueError(port, suffix, "one text")
        check_text_length(port, len(texts) + len(suffix))
        return texts + suffix
    suffixes = (suffix,) * len(texts) if isinstance(suffix, str) else suffix
    if len(texts) != len(suffixes):
        raise BadValueError(port, suffix, f"one text, or {len(texts)} of them")
    check_text_length(port, sum(map(len, texts)) + sum(map(len, suffixes)))
    return tuple(text + other for text, other in zip(texts, suffixes, strict=True))


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
            BadValueError: numbers of texts differ.
        """
        value = self.a
        for name in ("b", *self.series["input"]):
            value = appended(name, value, getattr(self, name))
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
            BadValueError: numbers of texts differ.
        """
        self.value_out = appended("suffix", self.value_in, self.suffix)


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
            BadValueError: there is no such operation.
        """
        change = _CASES[one_of("operation", self.operation, _CASES)]
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
            BadValueError: the parts are too many.
        """
        parts = self.string.split(self.delimiter) if self.string and self.delimiter else []
        checked_length("string", len(parts))
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
