"""Texts are never wider than they are taken to be."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from graphengine.drawing.text_metrics import fitted, width
from tests.drawing.reading import FINE, fonts

ASCII = st.text(st.characters(min_codepoint=32, max_codepoint=126), min_size=1, max_size=40)


@pytest.mark.parametrize("bold", [False, True])
@given(text=ASCII)
def test_a_text_is_no_wider_in_any_font_at_hand(bold: bool, text: str) -> None:
    for font in fonts(FINE, bold):
        assert font.getlength(text) <= width(text, FINE, bold=bold) + 0.01


@given(st.text(max_size=60), st.floats(20, 300), st.booleans())
@example("\x1f" * 10, 126.0, False)
def test_a_fitted_text_is_printable_and_within_its_width(text: str, limit: float, tail: bool) -> None:
    made = fitted(text, 12.0, limit, tail=tail)
    assert width(made, 12.0) <= limit
    assert made.isprintable()


def test_of_a_path_the_end_is_kept_and_of_another_text_the_beginning() -> None:
    assert fitted("/dd100/base_link/Lidar", 12.0, 80.0, tail=True).endswith("Lidar")
    assert fitted("/dd100/base_link/Lidar", 12.0, 80.0).startswith("/dd100")
    assert fitted("short", 12.0, 80.0) == "short"
