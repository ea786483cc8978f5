"""Texts found in others, taken out of them, put into them and replaced (`omni.graph.nodes`); places are counted in letters."""

from __future__ import annotations

from typing import Any

from graphengine.node import In, Int, Node, Out
from graphengine.nodes.data.sequences import INDEX, position
from graphengine.nodes.data.strings import check_text_length

_TEXT = "string|token"


class FindString(Node, type="omni.graph.nodes.FindString"):
    """Where a text first stands in another."""

    pos: Int = In(default=0, doc="place from which it is looked for; beyond the end it is not found")
    string: Any = In(type=_TEXT, required=True, doc="the text in which it is looked for")
    value: Any = In(type=_TEXT, required=True, doc="what is looked for; the empty text is not found")
    index: Int = Out(doc="place of its first letter, from 0; -1 where it is not found")

    def compute(self) -> None:
        """Look for it."""
        self.index = self.string.find(self.value, max(self.pos, 0)) if self.value else -1


class _Part(Node):
    """A part of a text, by its place and length."""

    count: Int = In(default=-1, doc="letters; -1 and what is too much reach to the end")
    index: Int = In(default=0, doc=INDEX)
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="the whole text")
    string_out: Any = Out(
        type=_TEXT, name="string", couple="text", doc="of the type of the input; of an empty one empty"
    )

    def ends(self) -> tuple[int, int]:
        """Where the part begins, and where what follows it does.

        Raises:
            BadValueError: there is no such place.
        """
        text: str = self.string_in
        if not text:
            return 0, 0
        start = position(self.index, len(text))
        return start, len(text) if self.count < 0 else start + self.count


class GetString(_Part, type="omni.graph.nodes.GetString"):
    """A part of a text."""

    def compute(self) -> None:
        """Cut it out.

        Raises:
            BadValueError: there is no such place.
        """
        start, stop = self.ends()
        self.string_out = self.string_in[start:stop]


class RemoveString(_Part, type="omni.graph.nodes.RemoveString"):
    """A text without a part of it."""

    def compute(self) -> None:
        """Leave it out.

        Raises:
            BadValueError: there is no such place.
        """
        start, stop = self.ends()
        self.string_out = self.string_in[:start] + self.string_in[stop:]


class InsertString(Node, type="omni.graph.nodes.InsertString"):
    """A text with another one put in."""

    index: Int = In(default=0, doc="0 or less puts it first, the text's length or more last")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="the text around it")
    value: Any = In(type=_TEXT, required=True, doc="is put in")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="of the type of the text around it")

    def compute(self) -> None:
        """Insert it.

        Raises:
            BadValueError: the text is too long.
        """
        index = max(self.index, 0)
        check_text_length("value", len(self.string_in) + len(self.value))
        self.string_out = self.string_in[:index] + self.value + self.string_in[index:]


class ReplaceString(Node, type="omni.graph.nodes.ReplaceString"):
    """A text with another one in the place of a part, where that first stands or wherever it does."""

    replace: Any = In(type=_TEXT, required=True, doc="the part that is looked for; the empty one is not found")
    replace_all: bool = In(default=False, doc="replaces it wherever it stands, not only where it first does")
    string_in: Any = In(type=_TEXT, name="string", couple="text", required=True, doc="the whole text")
    value: Any = In(type=_TEXT, required=True, doc="takes its place; may be empty")
    string_out: Any = Out(type=_TEXT, name="string", couple="text", doc="of the type of the whole text")

    def compute(self) -> None:
        """Replace it.

        Raises:
            BadValueError: the text is too long.
        """
        if not self.replace:
            self.string_out = self.string_in
            return
        pieces = self.string_in.split(self.replace, -1 if self.replace_all else 1)
        check_text_length("value", sum(map(len, pieces)) + len(self.value) * (len(pieces) - 1))
        self.string_out = self.value.join(pieces)
