"""BreakVector3."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

import pytest

from graphengine.build import Options
from graphengine.diagnostics import CheckError
from graphengine.node import In, Node, Out
from graphengine.registry import Registry
from graphengine.ros.definitions import Definitions
from graphengine.testing import RecordingContext
from graphengine.types import String
from nodes.math import BreakVector3
from tests.nodes.harness import Player, ready

ROLES = [f"{role}{base}[3]" for role in ("vector", "point", "normal", "color", "texcoord") for base in "dfh"]
TRIPLES = ["double[3]", "float[3]", "half[3]", "int[3]", *ROLES]


class Triple(Node, type="test.Triple"):
    """A vector (1, 2, 3) of the type that a literal says."""

    kind_of_vector: String = In(default="double[3]", name="type")

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """The output."""
        return {"value": Out(type=literals["type"])}

    def compute(self) -> None:
        """Put it out."""
        number = int if "int" in self.kind_of_vector else float
        self.value = (number(1), number(2), number(3))


def registry() -> Registry:
    made = Registry()
    made.add_module(importlib.import_module("nodes"), "graphengine", built_in=True)
    made.add(Triple)
    return made


def test_it_is_a_data_node() -> None:
    assert BreakVector3.kind() == "data"


def test_the_components_come_out_in_order() -> None:
    node = ready(BreakVector3, RecordingContext(), tuple_in=(1.5, -2.5, 3.5))
    node.compute()
    assert (node.x, node.y, node.z) == (1.5, -2.5, 3.5)


@pytest.mark.parametrize("vector_type", TRIPLES)
def test_in_a_graph_every_type_and_role_of_vector_is_taken_and_widens_to_double(play: Player, vector_type: str) -> None:
    text = f"""
        nodes:
          Tick: OnPlaybackTick
          Source: {{type: test.Triple, inputs: {{type: "{vector_type}"}}}}
          Break: BreakVector3
          X: {{type: PublishClock, inputs: {{topicName: x}}}}
          Y: {{type: PublishClock, inputs: {{topicName: y}}}}
          Z: {{type: PublishClock, inputs: {{topicName: z}}}}
        connections:
          - Tick.tick -> X.execIn
          - Tick.tick -> Y.execIn
          - Tick.tick -> Z.execIn
          - Source.value -> Break.tuple
          - Break.x -> X.timeStamp
          - Break.y -> Y.timeStamp
          - Break.z -> Z.timeStamp
        """
    playing = play.graph(text, options=Options(registry=registry()))
    playing.tick()
    assert [playing.published(f"/{name}")[0].clock.sec for name in "xyz"] == [1, 2, 3]


@pytest.mark.parametrize("vector_type", ["double[2]", "double[4]", "quatd[4]", "double[3][]", "string"])
def test_in_a_graph_what_is_no_triple_is_refused_at_the_wire(play: Player, vector_type: str) -> None:
    text = f"""
        nodes:
          Source: {{type: test.Triple, inputs: {{type: "{vector_type}"}}}}
          Break: BreakVector3
        connections: [Source.value -> Break.tuple]
        """
    with pytest.raises(CheckError, match=r"Source\.value is an? .*, Break\.tuple takes"):
        play.graph(text, options=Options(registry=registry()))


def test_in_a_graph_a_literal_needs_a_type_only_if_it_is_not_double(play: Player) -> None:
    text = """
        nodes:
          Tick: OnPlaybackTick
          Plain: {type: BreakVector3, inputs: {tuple: [0.5, 0, 0]}}
          Typed: {type: BreakVector3, inputs: {tuple: {type: "int[3]", value: [2, 0, 0]}}}
          One: {type: PublishClock, inputs: {topicName: one}}
          Other: {type: PublishClock, inputs: {topicName: other}}
        connections:
          - Tick.tick -> One.execIn
          - Tick.tick -> Other.execIn
          - Plain.x -> One.timeStamp
          - Typed.x -> Other.timeStamp
        """
    playing = play.graph(text)
    playing.tick()
    assert playing.published("/one")[0].clock.nanosec == 500_000_000
    assert playing.published("/other")[0].clock.sec == 2


def test_in_a_graph_it_needs_a_wire_or_a_value(play: Player) -> None:
    text = "nodes: {T: OnPlaybackTick, B: BreakVector3, C: PublishClock}\nconnections: [T.tick -> C.execIn, B.x -> C.timeStamp]"
    with pytest.raises(CheckError, match="B needs its input 'tuple'"):
        play.graph(text)
