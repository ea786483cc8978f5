"""Nodes that join, split and check strings, or change their case (`omni.graph.nodes`)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from graphengine.node import BadValueError, In, Node, Numbered, Out, PortType, String, Token, Tokens
from graphengine.nodes.checked import one_of
from graphengine.nodes.data.sequences import MAX_LENGTH, checked_length

TEXTS = "string|token|token[]"


def check_text_length(port: str, letters: int) -> None:
    """Check the total length of the strings that a node outputs.

    Args:
        port: OmniGraph name of the input that determines the length, for the error message.
        letters: total number of characters.

    Raises:
        BadValueError: the number of characters is above `MAX_LENGTH`.
    """
    if letters > MAX_LENGTH:
        raise BadValueError(port, letters, f"so short that the result has {MAX_LENGTH} characters or fewer")


def appended(port: str, texts: str | tuple[str, ...], suffix: str | tuple[str, ...]) -> str | tuple[str, ...]:
    """Return a string with a suffix appended, or several strings, each with a suffix appended.

    Args:
        port: OmniGraph name of the suffix input, for the error message.
        texts: string or strings to extend.
        suffix: suffix for all strings, or one for each string.

    Raises:
        BadValueError: there are several suffixes, but not one for each string; or the result is too long.
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
    """Concatenates strings. In Isaac Sim's menu, this node is called "Append String"."""

    numbered: ClassVar[Numbered] = {"input": lambda: In(type=TEXTS)}

    a: Any = In(type=TEXTS, required=True, doc="first string, or token[] whose elements are all extended")
    b: Any = In(type=TEXTS, required=True, doc="second string; a graph file can add inputs `input2`, `input3`, …")
    value: Any = Out(type=TEXTS, doc="concatenated string; has the type of `a`")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of `a`, which is also the type of the output."""
        return {"value": known["a"]} if "a" in known else {}

    def compute(self) -> None:
        """Set `value` to the concatenation of all inputs.

        Raises:
            BadValueError: an input has several strings, but not one for each string of `a`; or the result is too long.
        """
        value = self.a
        for name in ("b", *self.series["input"]):
            value = appended(name, value, getattr(self, name))
        self.value = value


class AppendString(Node, type="omni.graph.nodes.AppendString"):
    """Appends a suffix to a string.

    BuildString is the newer node type.
    """

    value_in: Any = In(type=TEXTS, name="value", required=True, doc="string to extend, or token[] of such strings")
    suffix: Any = In(type=TEXTS, required=True, doc="suffix, or token[] with one suffix for each element of `value`")
    value_out: Any = Out(type=TEXTS, name="value", doc="extended string; has the type of the input")

    def resolve_types(self, known: Mapping[str, PortType], variables: Mapping[str, PortType]) -> Mapping[str, PortType]:
        """Return the type of the input, which is also the type of the output."""
        return {"value_out": known["value_in"]} if "value_in" in known else {}

    def compute(self) -> None:
        """Set the output to the string with the suffix appended.

        Raises:
            BadValueError: `suffix` has several strings, but not one for each string of `value`; or the result is too long.
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
        doc="new case; Capitalize: upper case only for the first letter, Title: for the first letter of each word",
    )
    string_in: Any = In(type=TEXTS, name="string", couple="text", required=True, doc="string to change, or token[]")
    string_out: Any = Out(type=TEXTS, name="string", couple="text", doc="changed string; has the type of the input")

    def compute(self) -> None:
        """Set the output to the string in its new case.

        Raises:
            BadValueError: `operation` is unknown.
        """
        change = _CASES[one_of("operation", self.operation, _CASES)]
        text = self.string_in
        self.string_out = change(text) if isinstance(text, str) else tuple(map(change, text))


class SplitString(Node, type="omni.graph.nodes.SplitString"):
    """Splits a string at each occurrence of a delimiter."""

    delimiter: String = In(default=" ", doc="string that separates the parts")
    string: String = In(default="", doc="string to split")
    elements: Tokens = Out(doc="parts, which may be empty strings; none if `string` or `delimiter` is empty")

    def compute(self) -> None:
        """Set `elements` to the parts of the string.

        Raises:
            BadValueError: the string has more than `MAX_LENGTH` parts.
        """
        parts = self.string.split(self.delimiter) if self.string and self.delimiter else []
        checked_length("string", len(parts))
        self.elements = tuple(parts)


class StartsWith(Node, type="omni.graph.nodes.StartsWith"):
    """Checks whether a string starts with a prefix."""

    prefix: String = In(default="", doc="prefix to look for; an empty prefix matches every string")
    value: String = In(default="", doc="string to check")
    is_prefix: bool = Out(doc="whether `value` starts with `prefix`")

    def compute(self) -> None:
        """Set `isPrefix` to whether the string starts with the prefix."""
        self.is_prefix = self.value.startswith(self.prefix)


class EndsWith(Node, type="omni.graph.nodes.EndsWith"):
    """Checks whether a string ends with a suffix."""

    suffix: String = In(default="", doc="suffix to look for; an empty suffix matches every string")
    value: String = In(default="", doc="string to check")
    is_suffix: bool = Out(doc="whether `value` ends with `suffix`")

    def compute(self) -> None:
        """Set `isSuffix` to whether the string ends with the suffix."""
        self.is_suffix = self.value.endswith(self.suffix)
