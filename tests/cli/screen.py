"""What a terminal shows in the end of all that was written to it."""

from __future__ import annotations

import re

_PIECE = re.compile(r"\x1b\[([?0-9;]*)([A-Za-z])|([\r\n])|([^\x1b\r\n]+)")


def shown(written: str, columns: int) -> list[str]:
    """The lines of a terminal, scrolled ones included; fails at what it does not know."""
    lines, row, column = [""], 0, 0
    assert "".join(match[0] for match in _PIECE.finditer(written)) == written, repr(written)
    for match in _PIECE.finditer(written):
        argument, command, control, text = match.groups()
        if control == "\r":
            column = 0
        elif control == "\n":
            row += 1
        elif text:
            for letter in text:
                if column == columns:
                    row, column = row + 1, 0
                lines += [""] * (row + 1 - len(lines))
                lines[row] = lines[row][:column].ljust(column) + letter + lines[row][column + 1 :]
                column += 1
        elif (argument, command) == ("2", "K"):
            lines[row] = ""
        elif command == "A":
            row -= int(argument or 1)
        else:
            assert command == "m" or argument == "?25", match[0]  # colours, and whether the cursor is seen
        lines += [""] * (row + 1 - len(lines))
    return [line.rstrip() for line in lines]


def frames(written: str) -> list[str]:
    """What each line that was overwritten showed, without its colours."""
    plain = re.sub(r"\x1b\[[0-9;]*m|\x1b\[\?25[hl]|\x1b\[1A", "", written)
    return [piece for line in plain.split("\n") for piece in re.split(r"\r(?:\x1b\[2K)?", line) if piece]
