"""Nodes that search strings and extract, insert or replace parts of them (`omni.graph.nodes`).

Positions count characters from 0.
"""

from __future__ import annotations

from typing import Any

from graphengine.node import In, Int, Node, Out
from graphengine.nodes.data.sequences import INDEX, position
from graphengine.nodes.data.strings import check_text_length

_TEXT = "string|token"


class FindString(Node, type="omni.graph.nodes.FindString"):
    """Finds the first occurrence of `value` in `string`."""

    pos: Int = In(default=0, doc="position at which the search starts, from 0; nothing is found beyond the end")
    string: Any = In(type=_TEXT, required=True, doc="string to search in")
    value: Any = In(type=_TEXT, required=True, doc="string to search for; an empty string is never found")
    index: Int = Out(doc="position of `value` in `string`, from 0; -1 if `value` is not found")

    def compute(self) -> None:
        """Set `index` to the position of the first occurrence, or to -1."""
        self.index = self.string.find(self.value, max(self.pos, 0)) if self.value else -1


class _Part(Node):
    """Base class of nodes that extract or remove a part of a string, given by position and length."""

    count: Int = In(default=-1, doc="length of the part; a negative or too large length reaches to the end")
    index: Int = In(default=0, doc=f"position of the first character of the part: {INDEX}")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="string that contains the part")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="result; has the type of the input")

    def ends(self) -> tuple[int, int]:
        """Return the positions of the first character in the part and of the first character after the part.

        Raises:
            BadValueError: `index` is out of range.
        """
        text: str = self.string_in
        if not text:
            return 0, 0
        start = position(self.index, len(text))
        return start, len(text) if self.count < 0 else start + self.count


class GetString(_Part, type="omni.graph.nodes.GetString"):
    """Extracts a part of a string, given by position and length."""

    def compute(self) -> None:
        """Set the output to the part.

        Raises:
            BadValueError: `index` is out of range.
        """
        start, stop = self.ends()
        self.string_out = self.string_in[start:stop]


class RemoveString(_Part, type="omni.graph.nodes.RemoveString"):
    """Removes a part of a string, given by position and length."""

    def compute(self) -> None:
        """Set the output to the string without the part.

        Raises:
            BadValueError: `index` is out of range.
        """
        start, stop = self.ends()
        self.string_out = self.string_in[:start] + self.string_in[stop:]


class InsertString(Node, type="omni.graph.nodes.InsertString"):
    """Inserts a string into another string."""

    index: Int = In(default=0, doc="position of the insertion, limited to the range from 0 to the length")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="string to extend")
    value: Any = In(type=_TEXT, required=True, doc="string to insert")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="extended string; has the type of the input")

    def compute(self) -> None:
        """Set the output to the string with `value` inserted at `index`.

        Raises:
            BadValueError: the result is too long.
        """
        index = max(self.index, 0)
        check_text_length("value", len(self.string_in) + len(self.value))
        self.string_out = self.string_in[:index] + self.value + self.string_in[index:]


class ReplaceString(Node, type="omni.graph.nodes.ReplaceString"):
    """Replaces the first or all occurrences of one string in another string."""

    replace: Any = In(type=_TEXT, required=True, doc="string to search for; an empty string is never found")
    replace_all: bool = In(default=False, doc="true: replace all occurrences; false: only the first")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="string to change")
    value: Any = In(type=_TEXT, required=True, doc="replacement for `replace`; may be empty")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="changed string; has the type of the input")

    def compute(self) -> None:
        """Set the output to the string with the occurrences of `replace` replaced by `value`.

        Raises:
            BadValueError: the result is too long.
        """
        if not self.replace:
            self.string_out = self.string_in
            return
        pieces = self.string_in.split(self.replace, -1 if self.replace_all else 1)
        check_text_length("value", sum(map(len, pieces)) + len(self.value) * (len(pieces) - 1))
        self.string_out = self.value.join(pieces)
