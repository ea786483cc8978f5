"""Lengths in stage units."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.format.diagnostics import CheckError
from graphengine.nodes.core.units import OgnIsaacScaleToFromStageUnit
from tests.nodes.data.harness import computed, shown
from tests.nodes.harness import Player

both_ways = pytest.mark.parametrize("conversion", ["Convert to stage units", "Convert to meters"])


@both_ways
@pytest.mark.parametrize("length", [2, 2.5, (1.0, 2.0, 3.0)])
def test_a_length_stays_as_it_is(conversion: str, length: Any) -> None:
    assert computed(OgnIsaacScaleToFromStageUnit, value=length, conversion=conversion).result == length


@both_ways
def test_in_a_graph_a_length_keeps_its_type_too(play: Player, conversion: str) -> None:
    nodes = {"Scale": f"{{type: ScaleToFromStageUnit, inputs: {{value: [1.0, 2.0, 3.0], conversion: {conversion}}}}}"}
    assert shown(play, "double[3] Scale.result", nodes) == (1.0, 2.0, 3.0)


def test_in_a_graph_an_unknown_conversion_is_refused_with_the_two_legal_conversions(play: Player) -> None:
    with pytest.raises(CheckError, match="expected one of Convert to stage units, Convert to meters"):
        shown(
            play,
            "double Scale.result",
            {"Scale": "{type: ScaleToFromStageUnit, inputs: {value: 1.0, conversion: to feet}}"},
        )
