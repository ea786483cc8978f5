"""Search, extraction, insertion and replacement in strings (`omni.graph.nodes`); positions count characters from 0."""

from __future__ import annotations

from typing import Any

from graphengine.node import In, Int, Node, Out
from graphengine.nodes.data.sequences import INDEX, position
from graphengine.nodes.data.strings import check_text_length

_TEXT = "string|token"


class FindString(Node, type="omni.graph.nodes.FindString"):
    """Position of the first occurrence of `value` in `string`."""

    pos: Int = In(default=0, doc="position at which the search starts, from 0; beyond the end, nothing is found")
    string: Any = In(type=_TEXT, required=True, doc="string to search in")
    value: Any = In(type=_TEXT, required=True, doc="string to search for; an empty string is never found")
    index: Int = Out(doc="position at which `value` was found, from 0; -1 if it was not")

    def compute(self) -> None:
        """Search for the string."""
        self.index = self.string.find(self.value, max(self.pos, 0)) if self.value else -1


class _Part(Node):
    """Base of nodes for a part of a string, given by position and length."""

    count: Int = In(default=-1, doc="number of characters; a negative or too large number extends to the end")
    index: Int = In(default=0, doc=f"position of the first character: {INDEX}")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="input string")
    string_out: Any = Out(
        type=_TEXT, name="string", couple="text", doc="result, of the input's type; empty for an empty input"
    )

    def ends(self) -> tuple[int, int]:
        """Return the positions of the part's first character, and of the character after its last.

        Raises:
            BadValueError: the position is out of range.
        """
        text: str = self.string_in
        if not text:
            return 0, 0
        start = position(self.index, len(text))
        return start, len(text) if self.count < 0 else start + self.count


class GetString(_Part, type="omni.graph.nodes.GetString"):
    """Extracts a part of a string."""

    def compute(self) -> None:
        """Extract the part.

        Raises:
            BadValueError: the position is out of range.
        """
        start, stop = self.ends()
        self.string_out = self.string_in[start:stop]


class RemoveString(_Part, type="omni.graph.nodes.RemoveString"):
    """Removes a part of a string."""

    def compute(self) -> None:
        """Remove the part.

        Raises:
            BadValueError: the position is out of range.
        """
        start, stop = self.ends()
        self.string_out = self.string_in[:start] + self.string_in[stop:]


class InsertString(Node, type="omni.graph.nodes.InsertString"):
    """Inserts a string into another."""

    index: Int = In(
        default=0, doc="position of the inserted string; below 0 inserts at the start, beyond the end appends"
    )
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="string to insert into")
    value: Any = In(type=_TEXT, required=True, doc="string to insert")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="result, of the input's type")

    def compute(self) -> None:
        """Insert the string.

        Raises:
            BadValueError: the result is too long.
        """
        index = max(self.index, 0)
        check_text_length("value", len(self.string_in) + len(self.value))
        self.string_out = self.string_in[:index] + self.value + self.string_in[index:]


class ReplaceString(Node, type="omni.graph.nodes.ReplaceString"):
    """Replaces the first occurrence of one string in another, or all occurrences."""

    replace: Any = In(type=_TEXT, required=True, doc="string to search for; an empty string is never found")
    replace_all: bool = In(default=False, doc="true: replace all occurrences; false: only the first")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="input string")
    value: Any = In(type=_TEXT, required=True, doc="replacement, which may be empty")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="result, of the input's type")

    def compute(self) -> None:
        """Replace the occurrences.

        Raises:
            BadValueError: the result is too long.
        """
        if not self.replace:
            self.string_out = self.string_in
            return
        pieces = self.string_in.split(self.replace, -1 if self.replace_all else 1)
        check_text_length("value", sum(map(len, pieces)) + len(self.value) * (len(pieces) - 1))
        self.string_out = self.value.join(pieces)
