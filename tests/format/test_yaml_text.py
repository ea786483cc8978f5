"""Values as text of YAML files."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from graphengine.format.yaml_text import scalar


@given(st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text())
def test_a_scalar_is_read_as_the_same_value_by_other_yaml_readers(value: object) -> None:
    read = yaml.safe_load(scalar(value))
    assert (type(read), read) == (type(value), value)


@pytest.mark.parametrize(
    ("value", "text"), [(3e-07, "3.0e-07"), (3.5e-07, "3.5e-07"), (1e16, "1.0e+16"), (0.25, "0.25")]
)
def test_a_power_of_ten_has_a_point_without_which_yaml_1_1_takes_it_for_a_string(value: float, text: str) -> None:
    assert scalar(value) == text
