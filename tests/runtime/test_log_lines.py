"""The newest log messages of a session are kept, with their time and their number."""

from __future__ import annotations

from graphengine.runtime.log_lines import LONGEST_LINE, MOST_LINES, LogLines


def test_messages_after_a_number_come_in_their_order() -> None:
    times = iter((0.0, 0.5, 1.0))
    lines = LogLines()
    lines.time = lambda: next(times)
    for text in ("first", "second", "third"):
        lines.add("warning", "/graph/Node", text)
    assert [(line.number, line.time, line.text) for line in lines.after(1)] == [(2, 0.5, "second"), (3, 1.0, "third")]
    assert lines.after(3) == []


def test_a_repeated_message_is_counted_and_has_the_number_of_the_last() -> None:
    lines = LogLines()
    for text in ("same", "other", "same"):
        lines.add("info", "", text)
    assert [(line.number, line.text, line.count) for line in lines.after(0)] == [(2, "other", 1), (3, "same", 2)]


def test_the_oldest_messages_go_and_long_ones_are_cut() -> None:
    lines = LogLines()
    for number in range(MOST_LINES + 5):
        lines.add("info", "", str(number) if number else "")
    lines.add("error", "", "x" * (LONGEST_LINE + 1))
    kept = lines.after(0)
    assert len(kept) == MOST_LINES
    assert kept[0].text == "6"
    assert len(kept[-1].text) == LONGEST_LINE
