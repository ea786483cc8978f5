"""What a node class may say, and what its instances are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pytest

from graphengine.messages.definitions import DEFINITIONS, Definitions
from graphengine.node import Bound, ExecIn, ExecOut, Fire, In, Node, Numbered, Out, Pushes, State, node
from graphengine.node.node_class import NodeMeta, grown
from graphengine.node.types import Doubles, Token, Vector3d
from tests.compiler.nodes_for_tests import actions, data, events, latent, pushers


class Controller(Node, type="test.Controller"):
    """A node with every kind of port."""

    exec_in = ExecIn()
    wheel_radius: float = In(default=0.1, gt=0.0)
    mode: Token = In(default="fast", tokens=("fast", "slow"))
    gains: Doubles = In(default=[1.0, 2.0])
    offset: Vector3d = In(default=(1.0, 0.0, 0.0))
    exec_out = ExecOut()
    command: Doubles = Out(default=[0.0, 0.0])
    calls: int = State(default=0)
    memory: list[int] = State(factory=list)
    bound: object = Bound()

    def compute(self) -> None:
        self.calls += 1


# Names


def test_a_port_has_the_name_of_its_field_in_camel_case_or_the_given_name() -> None:
    assert list(Controller.ports) == [
        *("inputs:execIn", "inputs:wheelRadius", "inputs:mode", "inputs:gains", "inputs:offset"),
        *("outputs:execOut", "outputs:command", "state:calls", "state:memory", "state:bound"),
    ]
    assert actions.Counter.ports["inputs:reset"].field == "reset_in"


@pytest.mark.parametrize("name", ["reset", "compute", "setup", "fields", "ports", "kind", "clear", "reads", "gated"])
def test_a_port_with_the_name_of_a_member_of_node_is_refused(name: str) -> None:
    with pytest.raises(
        TypeError, match=f"{name}: the name is taken; call it {name}_in or {name}_out, and set the port's name"
    ):
        NodeMeta("Bad", (Node,), {name: ExecIn()})


@pytest.mark.parametrize("name", ["type", "tuple", "close", "update", "active", "_hidden", "id", "min", "input"])
def test_a_port_with_a_name_that_the_class_body_or_the_engine_uses_is_refused(name: str) -> None:
    with pytest.raises(TypeError, match="the name is taken"):
        NodeMeta("Bad", (Node,), {name: ExecIn()})


def test_a_port_with_the_name_of_a_port_of_the_base_class_is_refused() -> None:
    with pytest.raises(TypeError, match="wheel_radius: the name is taken"):

        class Bad(Controller):
            wheel_radius: float = In(default=0.2)


def test_an_input_and_an_output_may_have_one_name_in_omnigraph() -> None:
    class Passes(Node):
        value_in: float = In(default=1.0, name="value")
        value_out: float = Out(name="value")

    assert set(Passes.ports) == {"inputs:value", "outputs:value"}


# Types and defaults


def test_a_port_without_a_known_type_is_refused() -> None:
    with pytest.raises(TypeError, match=r"Bad\.speed: no port type is known for .*complex"):

        class Bad(Node):
            speed: complex = In(default=0.0)


@pytest.mark.parametrize(("default", "why"), [("fast", "expected a number"), (-1.0, "expected a value ≥ 0")])
def test_a_default_that_is_not_legal_is_refused(default: Any, why: str) -> None:
    with pytest.raises(TypeError, match=f"Bad.speed: default .*: {why}"):

        class Bad(Node):
            speed: float = In(default=default, ge=0.0)


def test_a_port_without_a_default_has_the_zero_of_its_type() -> None:
    assert actions.Counter.fields["count"].default == 0.0
    assert actions.Show.fields["value"].default is None


def test_defaults_are_shared_and_cannot_be_changed() -> None:
    one, other = Controller(), Controller()
    assert one.gains is other.gains
    with pytest.raises(ValueError, match="read-only"):
        one.gains[0] = 5.0
    with pytest.raises(ValueError, match="read-only"):
        one.command[0] = 5.0


def test_a_mutable_default_of_a_state_field_is_refused_without_a_factory() -> None:
    with pytest.raises(TypeError, match=r"Bad\.seen: default .* is mutable; write factory=list instead"):

        class Bad(Node):
            seen: list[int] = State(default=[])

    one, other = Controller(), Controller()
    one.memory.append(1)
    assert other.memory == []


def test_clear_resets_outputs_and_state_but_not_inputs_and_bound_fields() -> None:
    one = Controller(wheel_radius=0.5)
    one.bound = handle = object()
    one.compute()
    one.memory.append(1)
    one.command = np.ones(2)
    one.clear()
    assert (one.calls, one.memory, one.command.tolist(), one.wheel_radius) == (0, [], [0.0, 0.0], 0.5)
    assert one.bound is handle


# Instances


def test_the_constructor_converts_inputs_to_the_representation_of_their_types() -> None:
    one = Controller(wheel_radius=1, gains=np.array([3, 4]), offset=(1, 2, 3))
    assert (one.wheel_radius, one.gains.tolist(), one.offset) == (1.0, [3.0, 4.0], (1.0, 2.0, 3.0))


def test_a_literal_nan_is_refused_without_bounds_too() -> None:
    with pytest.raises(ValueError, match=r"Add.a: expected a number other than NaN, got nan"):
        data.Add(a=math.nan)


@pytest.mark.parametrize(
    ("values", "error", "why"),
    [
        ({"wheel_radius": "0.1"}, TypeError, "Controller.wheel_radius: expected a number, got '0.1'"),
        ({"wheel_radius": 0.0}, ValueError, "Controller.wheel_radius: expected a value > 0, got 0.0"),
        ({"wheel_radius": float("nan")}, ValueError, "Controller.wheel_radius: expected a value > 0, got nan"),
        ({"mode": "medium"}, ValueError, "Controller.mode: expected one of fast, slow, got 'medium'"),
        ({"wheel_radus": 0.1}, TypeError, "Controller has no input 'wheel_radus'; did you mean 'wheel_radius'?"),
        ({"command": []}, TypeError, "Controller has no input 'command'"),
        ({"exec_in": 1}, TypeError, "Controller has no input 'exec_in'"),
        ({"calls": 1}, TypeError, "Controller has no input 'calls'"),
    ],
)
def test_the_constructor_refuses_unknown_inputs_and_illegal_values(
    values: dict[str, Any], error: type[Exception], why: str
) -> None:
    with pytest.raises(error) as caught:
        Controller(**values)
    assert str(caught.value).startswith(why)


def test_instances_have_slots_and_no_dict() -> None:
    with pytest.raises(AttributeError):
        Controller().misspelt = 1  # type: ignore[attr-defined]
    assert not hasattr(Controller(), "__dict__")


def test_execution_outputs_are_bits_that_can_be_combined() -> None:
    branch = actions.Branch()
    assert (branch.exec_true, branch.exec_false) == (1, 2)
    assert actions.Branch(condition=True).exec_true | actions.Branch().exec_false == 3


# Kinds


def test_ports_and_methods_of_a_class_determine_its_kind() -> None:
    kinds: dict[str, list[type[Node]]] = {
        "data": [data.Add, data.Constant, data.Twice, data.Ticket],
        "action": [actions.Do, actions.Branch, actions.Gate],
        "event": [events.Tick, events.Every],
        "pusher": [pushers.ForLoop, events.OnMessage],
        "latent": [latent.Delay, latent.Stages],
    }
    assert all(cls.kind() == kind for kind, classes in kinds.items() for cls in classes)


def test_an_action_with_several_execution_outputs_is_gated_without_the_keyword() -> None:
    assert (actions.Branch.gated, actions.Door.gated, actions.Do.gated) == (True, True, False)


def test_a_subclass_adds_ports_and_keeps_kind_bits_and_keywords() -> None:
    class More(actions.Gate, type="test.More"):
        third = ExecOut()

        def compute(self) -> Fire:
            return self.third

    assert More.counts
    assert More.gated
    assert More.ports["outputs:third"].mask == 2
    assert More().third == 2


def test_latent_nodes_know_whether_they_are_active() -> None:
    delay = latent.Delay()
    assert delay.active is False
    delay.active = True
    delay.clear()
    assert delay.active is False


# Data nodes of functions


def test_a_function_becomes_a_data_node() -> None:
    assert data.Twice.kind() == "data"
    assert list(data.Twice.ports) == ["inputs:number", "outputs:value"]
    twice: Any = data.Twice(number=4.0)
    twice.compute()
    assert twice.value == 8.0


def test_a_function_keeps_its_name_doc_and_defaults() -> None:
    @node("test.Scaled", volatile=True, aliases=["test.OldScaled"])
    def Scaled(number: float, factor: float = 3.0) -> float:
        """So many times a number."""
        return number * factor

    assert (Scaled.__name__, Scaled.__doc__) == ("Scaled", "So many times a number.")
    assert (Scaled.type_name, Scaled.aliases, Scaled.volatile) == ("test.Scaled", ("test.OldScaled",), True)
    assert Scaled.fields["factor"].default == 3.0


def test_a_function_with_an_argument_named_value_is_refused() -> None:
    with pytest.raises(TypeError, match="value: the name is reserved for the output"):

        @node("test.Bad")
        def Bad(value: float) -> float:
            return value


def test_a_function_without_a_return_annotation_is_refused() -> None:
    with pytest.raises(TypeError, match=r"Bad\.value: no port type is known"):

        @node("test.Bad")
        def Bad(number: float):  # type: ignore[no-untyped-def]
            return number


# Dynamic ports


def test_literals_grow_ports_and_the_same_literals_give_the_same_class() -> None:
    three = grown(data.Sums, {"count": 3}, DEFINITIONS)
    assert [name for name in three.fields if name.startswith("input")] == ["input0", "input1", "input2"]
    assert grown(data.Sums, {"count": 3}, DEFINITIONS) is three
    assert grown(data.Sums, {"count": 2}, DEFINITIONS) is not three
    assert issubclass(three, data.Sums)
    assert (three.__name__, three.type_name) == ("Sums", "test.Sums")


def test_literals_that_grow_other_defaults_give_another_class() -> None:
    one, other = grown(data.Sums, {"first": 1.0}, DEFINITIONS), grown(data.Sums, {"first": 2.0}, DEFINITIONS)
    assert (one.fields["input0"].default, other.fields["input0"].default) == (1.0, 2.0)


def test_grown_execution_ports_with_other_names_give_another_class() -> None:
    class Grows(Node, type="test.Grows"):
        exec_in = ExecIn()

        @classmethod
        def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
            return {"first": ExecOut(name=literals["name"])}

        def compute(self) -> Pushes:
            yield 0

    assert "outputs:a" in grown(Grows, {"name": "a"}, DEFINITIONS).ports
    assert "outputs:b" in grown(Grows, {"name": "b"}, DEFINITIONS).ports


def test_a_class_without_dynamic_ports_is_itself() -> None:
    assert grown(actions.Do, {"a": 1.0}, DEFINITIONS) is actions.Do


class Ways(Node, type="test.Ways"):
    """Has as many outputs as its file names."""

    numbered: ClassVar[Numbered] = {"way": ExecOut, "weight": lambda: In(type="double", default=1.0)}

    exec_in = ExecIn()
    way0 = ExecOut()


def test_wires_and_values_that_name_numbered_ports_create_them() -> None:
    made = grown(Ways, {"weight3": 2.0}, DEFINITIONS, ["way1", "way10", "way2", "execIn"])
    assert made.series == {"way": ("way0", "way1", "way2", "way10"), "weight": ("weight3",)}
    assert grown(Ways, {"weight3": 5.0}, DEFINITIONS, ["way2", "way10", "way1"]).series == made.series


def test_a_name_without_a_number_creates_no_port() -> None:
    assert grown(Ways, {}, DEFINITIONS, ["way", "way-1", "wayx", "way0", "way007", "way10000", "way\u0661"]) is Ways


def test_numbered_ports_without_wires_and_values_do_not_exist() -> None:
    assert Ways.series == {"way": ("way0",), "weight": ()}


def test_a_recorded_number_may_be_out_of_bounds_but_a_recorded_string_must_be_legal() -> None:
    fields = Controller.fields
    assert fields["wheel_radius"].check(-0.1, recorded=True) == -0.1
    with pytest.raises(ValueError, match="expected one of fast, slow"):
        fields["mode"].check("none", recorded=True)
