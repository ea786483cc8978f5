"""Operations on strings (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from graphengine.node import BadValueError, In, Node, Numbered, Out, PortType, String, Token, Tokens
from graphengine.nodes.checked import one_of
from graphengine.nodes.data.sequences import MAX_LENGTH, checked_length

TEXTS = "string|token|token[]"


def check_text_length(port: str, letters: int) -> None:
    """Check the length of the string or strings that a node makes.

    Args:
        port: OmniGraph's name of the input that makes them long, for the error.
        letters: total number of characters.

    Raises:
        BadValueError: the number is above `MAX_LENGTH`.
    """
    if letters > MAX_LENGTH:
        raise BadValueError(port, letters, f"so short that the result has {MAX_LENGTH} characters or fewer")


def appended(port: str, texts: str | tuple[str, ...], suffix: str | tuple[str, ...]) -> str | tuple[str, ...]:
    """Append a suffix to a string, or to each of several strings.

    Args:
        port: OmniGraph's name of the suffix input, for the error.
        texts: string or strings to extend.
        suffix: suffix for all strings, or one for each string.

    Raises:
        BadValueError: the number of suffixes is neither 1 nor that of the strings, or the result is too long.
    """
    if isinstance(texts, str):
        if not isinstance(suffix, str):
            raise BadValueError(port, suffix, "one string")
        check_text_length(port, len(texts) + len(suffix))
        return texts + suffix
    suffixes = (suffix,) * len(texts) if isinstance(suffix, str) else suffix
    if len(texts) != len(suffixes):
        raise BadValueError(port, suffix, f"one string, or {len(texts)} strings")
    check_text_length(port, sum(map(len, texts)) + sum(map(len, suffixes)))
    return tuple(text + other for text, other in zip(texts, suffixes, strict=True))


class BuildString(Node, type="omni.graph.nodes.BuildString"):
    """Concatenation of strings; "Append String" in Isaac Sim's menu."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=TEXTS)}

    a: Any = In(
        type=TEXTS, required=True, doc="first string, or token[]; the other inputs are appended to each of its elements"
    )
    b: Any = In(
        type=TEXTS, required=True, doc="second string; a graph file can name further inputs `input2`, `input3`, …"
    )
    value: Any = Out(type=TEXTS, doc="concatenation, of the type of `a`")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of `a` for the output."""
        return {"value": known["a"]} if "a" in known else {}

    def compute(self) -> None:
        """Concatenate the strings.

        Raises:
            BadValueError: the numbers of strings differ.
        """
        value = self.a
        for name in ("b", *self.series["input"]):
            value = appended(name, value, getattr(self, name))
        self.value = value


class AppendString(Node, type="omni.graph.nodes.AppendString"):
    """A string with a suffix appended. An older type than BuildString."""

    value_in: Any = In(
        type=TEXTS, name="value", required=True, doc="string to extend, or token[] to extend each of its elements"
    )
    suffix: Any = In(
        type=TEXTS, required=True, doc="string to append, or token[] with one string for each element of `value`"
    )
    value_out: Any = Out(type=TEXTS, name="value", doc="result, of the input's type")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the input for the output."""
        return {"value_out": known["value_in"]} if "value_in" in known else {}

    def compute(self) -> None:
        """Append the suffix.

        Raises:
            BadValueError: the numbers of strings differ.
        """
        self.value_out = appended("suffix", self.value_in, self.suffix)


_CASES: dict[str, Callable[[str], str]] = {
    "UpperCase": str.upper,
    "LowerCase": str.lower,
    "Capitalize": str.capitalize,
    "Title": lambda text: " ".join(map(str.capitalize, text.split(" "))),
}


class CapitalizeString(Node, type="omni.graph.nodes.CapitalizeString"):
    """Changes a string to upper or lower case, or capitalizes the string or each of its words."""

    operation: Token = In(
        default="UpperCase",
        tokens=tuple(_CASES),
        doc="change of case; Capitalize: first letter of the string, Title: first letter of each word",
    )
    string_in: Any = In(type=TEXTS, name="string", couple="text", required=True, doc="string, or array of tokens")
    string_out: Any = Out(type=TEXTS, name="string", couple="text", doc="result, of the input's type")

    def compute(self) -> None:
        """Change the case.

        Raises:
            BadValueError: the operation is unknown.
        """
        change = _CASES[one_of("operation", self.operation, _CASES)]
        text = self.string_in
        self.string_out = change(text) if isinstance(text, str) else tuple(map(change, text))


class SplitString(Node, type="omni.graph.nodes.SplitString"):
    """Splits a string at a delimiter."""

    delimiter: String = In(default=" ", doc="string to split at")
    string: String = In(default="", doc="string to split")
    elements: Tokens = Out(doc="parts, which may be empty; none if `string` or `delimiter` is empty")

    def compute(self) -> None:
        """Split the string.

        Raises:
            BadValueError: the string has too many parts.
        """
        parts = self.string.split(self.delimiter) if self.string and self.delimiter else []
        checked_length("string", len(parts))
        self.elements = tuple(parts)


class StartsWith(Node, type="omni.graph.nodes.StartsWith"):
    """Whether a string starts with a prefix."""

    prefix: String = In(default="", doc="prefix to look for; an empty prefix matches every string")
    value: String = In(default="", doc="string to check")
    is_prefix: bool = Out(doc="whether `value` starts with `prefix`")

    def compute(self) -> None:
        """Compare the start of the string with the prefix."""
        self.is_prefix = self.value.startswith(self.prefix)


class EndsWith(Node, type="omni.graph.nodes.EndsWith"):
    """Whether a string ends with a suffix."""

    suffix: String = In(default="", doc="end to look for; every string ends with the empty string")
    value: String = In(default="", doc="string to check")
    is_suffix: bool = Out(doc="whether `value` ends with `suffix`")

    def compute(self) -> None:
        """Compare the end of the string with the suffix."""
        self.is_suffix = self.value.endswith(self.suffix)
