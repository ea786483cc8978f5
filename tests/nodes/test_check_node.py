"""What check_node finds in a class that is not sound; each class here has one fault, and the last has many."""

from __future__ import annotations

import itertools
import random
from typing import Any

import pytest

from graphengine.node import Bound, Context, ExecIn, ExecOut, Fire, In, Node, Out, Pushes, State
from graphengine.node.node_class import NodeClassError, NodeMeta
from graphengine.node.types import Doubles, Target, Tokens
from graphengine.testing import RecordingContext, check_node


def complaint(cls: Any, **inputs: Any) -> str:
    """What check_node says, without its first line."""
    with pytest.raises(NodeClassError) as caught:
        check_node(cls, **inputs)
    first, *lines = str(caught.value).split("\n  - ")
    assert first.endswith(f"{cls.__qualname__} fails the node check:")
    return "; ".join(lines)


class Sound(Node, type="test.Sound"):
    """Doubles a speed."""

    exec_in = ExecIn()
    wheel_speed: float = In(default=1.0, unit="rad/s")
    doubled_speed: float = Out(unit="rad/s")
    exec_out = ExecOut()

    def compute(self) -> None:
        self.doubled_speed = 2.0 * self.wheel_speed


def test_a_sound_class_passes() -> None:
    check_node(Sound)


def test_a_docstring_is_needed() -> None:
    class Silent(Node, type="test.Silent"):
        pass

    assert "first line of its docstring" in complaint(Silent)


@pytest.mark.parametrize("text", ["This node doubles.", "A node that doubles.", "Doubles without an end"])
def test_a_docstring_begins_with_a_fact(text: str) -> None:
    class Chatty(Node, type="test.Chatty"):
        __doc__ = text

    assert repr(text) in complaint(Chatty)


def test_a_name_of_one_word_needs_a_doc() -> None:
    class Short(Node, type="test.Short"):
        """Takes a gain."""

        gain: float = In(default=1.0)

    assert complaint(Short) == "gain: a port whose name is one word needs a description, `doc=`"


@pytest.mark.parametrize("field", ["wheel_speed", "joint_velocities", "time_stamp", "max_force"])
def test_a_physical_number_needs_a_unit(field: str) -> None:
    body = {field: In(default=0.0), "__annotations__": {field: float}, "__doc__": "Takes a number."}
    physical = NodeMeta("Physical", (Node,), body, type="test.Physical")
    assert "a physical quantity needs a unit" in complaint(physical)


def test_a_registered_name_has_several_parts() -> None:
    class Nameless(Node, type="Nameless"):
        """Has a name without a dot."""

    assert "type= is 'Nameless'" in complaint(Nameless)


def test_a_name_belongs_to_one_class() -> None:
    class Clock(Node, type="test.Clock", aliases=["isaacsim.ros2.bridge.ROS2PublishClock"]):
        """Takes a name that is taken."""

    assert (
        complaint(Clock)
        == "the type name 'isaacsim.ros2.bridge.ROS2PublishClock' belongs to graphengine.nodes.ros2.state.ROS2PublishClock"
    )


def test_two_ports_of_a_side_have_two_names() -> None:
    class Twice(Node, type="test.Twice"):
        """Calls two ports alike."""

        one: float = In(default=0.0, name="gain", doc="one")
        other: float = In(default=0.0, name="gain", doc="other")

    assert complaint(Twice) == "2 ports are called inputs:gain"


def test_a_default_that_is_not_given_is_legal_too() -> None:
    class Positive(Node, type="test.Positive"):
        """Divides by a gain."""

        loop_gain: float = In(gt=0.0)

    assert complaint(Positive) == "loopGain: the default 0.0 is not valid: expected a value > 0"


def test_an_unset_input_of_zero_may_be_out_of_bounds() -> None:
    class Positive(Node, type="test.Positive"):
        """Divides by a gain."""

        loop_gain: float = In(gt=0.0, unset=True)

    check_node(Positive)


def test_a_bound_that_json_cannot_hold_is_found() -> None:
    class Boundless(Node, type="test.Boundless"):
        """Has an infinite bound."""

        loop_gain: float = In(default=0.0, le=float("inf"))

    assert "cannot be described as JSON Schema" in complaint(Boundless)


def test_an_attribute_that_is_not_declared_is_found() -> None:
    class Misspelt(Node, type="test.Misspelt"):
        """Writes an attribute that it does not have."""

        doubled_value: float = Out()

        def compute(self) -> None:
            self.dubled_value = 1.0

    assert "AttributeError" in complaint(Misspelt)
    assert "dubled_value" in complaint(Misspelt)


def test_a_state_that_setup_does_not_bind_is_found() -> None:
    class Unbound(Node, type="test.Unbound"):
        """Reads a handle that nobody bound."""

        handle: object = Bound()

        def compute(self) -> None:
            print(self.handle)  # noqa: T201

    assert "handle" in complaint(Unbound)


def test_a_base_without_slots_is_found() -> None:
    class Mixin:
        pass

    class Open(Mixin, Node, type="test.Open"):
        """Has a dict where mistakes hide."""

    assert "a base class lacks __slots__" in complaint(Open)


def test_random_numbers_that_do_not_come_from_the_context_are_found() -> None:
    class Dice(Node, type="test.Dice"):
        """Throws dice."""

        thrown_number: float = Out()

        def compute(self) -> None:
            self.thrown_number = random.random()

    assert "two instances with the same inputs behave differently" in complaint(Dice)


def test_random_numbers_from_the_context_are_accepted() -> None:
    class Seeded(Node, type="test.Seeded", volatile=True):
        """Throws the session's dice."""

        thrown_number: float = Out()
        source: object = Bound()

        def setup(self, context: Context) -> None:
            self.source = context.random()

        def compute(self) -> None:
            self.thrown_number = self.source.random()  # type: ignore[attr-defined]

    check_node(Seeded)


def test_mutable_state_shared_by_instances_is_found() -> None:
    counter = itertools.count()

    class Shared(Node, type="test.Shared"):
        """Counts for all instances."""

        next_number: float = Out()

        def compute(self) -> None:
            self.next_number = float(next(counter))

    assert "two instances" in complaint(Shared)


def test_state_that_a_node_loses_for_good_at_a_stop_is_found() -> None:
    class Forgetful(Node, type="test.Forgetful"):
        """Binds a handle to a State that a stop sets back."""

        names: Tokens = State(default=())
        known_names: Tokens = Out()

        def setup(self, context: Context) -> None:
            self.names = ("left", "right")

        def compute(self) -> None:
            self.known_names = self.names

    assert "behaves differently after a stop" in complaint(Forgetful)


def test_a_node_that_refuses_only_its_second_play_is_found() -> None:
    class Tired(Node, type="test.Tired"):
        """Works once."""

        ready_for_more: bool = State(default=False)

        def setup(self, context: Context) -> None:
            self.ready_for_more = True

        def compute(self) -> None:
            if not self.ready_for_more:
                raise ValueError("never again")

    assert "behaves differently after a stop" in complaint(Tired)


def test_state_that_survives_a_stop_is_found() -> None:
    class Elephant(Node, type="test.Elephant"):
        """Keeps a count beyond its State."""

        box: list[int] = Bound()
        rounds: float = Out(doc="how many")

        def setup(self, context: Context) -> None:
            self.box = []

        def compute(self) -> None:
            self.box.append(1)
            self.rounds = float(len(self.box))

    assert "behaves differently after a stop" in complaint(Elephant)


def test_a_node_that_returns_its_output_to_fire_must_be_gated() -> None:
    class Firing(Node, type="test.Firing"):
        """Returns its output pin without being gated."""

        exec_in = ExecIn()
        exec_out = ExecOut()

        def compute(self) -> Fire:
            return self.exec_out

    assert "was not declared with gated=True" in complaint(Firing)


def test_check_node_runs_pushers_and_latent_nodes() -> None:
    class Forever(Node, type="test.Forever"):
        """Pushes without an end."""

        exec_in = ExecIn()
        exec_out = ExecOut()
        rounds: float = Out(doc="how many")

        def compute(self) -> Pushes:
            while True:
                self.rounds += 1.0
                yield self.exec_out

    class Wrong(Node, type="test.Wrong"):
        """Fails in a later tick."""

        exec_in = ExecIn()

        def compute(self) -> None:
            self.active = True

        def update(self) -> None:
            raise KeyError("later")

    check_node(Forever)
    assert "KeyError" in complaint(Wrong)


def test_a_node_may_raise_bad_value_error_for_its_defaults() -> None:
    class Strict(Node, type="test.Strict"):
        """Divides by a gain."""

        loop_gain: float = In(default=0.0)

        def compute(self) -> None:
            if self.loop_gain == 0.0:
                raise ValueError("loopGain must not be 0")

    check_node(Strict)
    check_node(Strict, loop_gain=1.0)


def test_missing_required_inputs_are_asked_for() -> None:
    class Needy(Node, type="test.Needy"):
        """Needs a robot, and one of two frames."""

        robot: Target = In(required=True, setup=True, doc="prim of the robot")
        one_frame: Target = In(required="frame", setup=True)
        other_frame: Target = In(required="frame", setup=True)

        def setup(self, context: Context) -> None:
            context.articulation(self.robot[0])

    def with_a_robot() -> RecordingContext:
        context = RecordingContext()
        context.world.add_robot("/robot")
        return context

    asked = "check_node needs values for required inputs: "
    assert complaint(Needy) == f"{asked}robot, one_frame, other_frame"
    assert complaint(Needy, one_frame="/robot") == f"{asked}robot"
    check_node(Needy, with_a_robot, robot="/robot", other_frame="/robot")


def test_a_constructor_argument_that_is_not_an_input_is_reported() -> None:
    assert "TypeError" in complaint(Sound, wheel_sped=1.0)


def test_all_omissions_are_reported_at_once() -> None:
    class Bad(Node, type="Bad"):
        """this is bad"""

        gain: float = In(gt=0.0)
        speed: Doubles = Out(doc="of wheels")

        def compute(self) -> None:
            self.sped = 0

    assert len(complaint(Bad).split("; ")) >= 6
