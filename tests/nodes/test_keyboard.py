"""Which modifiers OnKeyboardInput wants held, and which not."""

from __future__ import annotations

import pytest

from graphengine.nodes.action.keyboard import OnKeyboardInput
from graphengine.testing import RecordingContext
from tests.nodes.harness import ready
from tests.nodes.test_events import typed


@pytest.mark.parametrize("held", ["LeftShift", "RightControl", "LeftAlt"])
def test_a_press_does_not_count_while_a_modifier_that_is_not_required_is_held(
    held: str, context: RecordingContext
) -> None:
    node = ready(OnKeyboardInput, context, key_in="D")
    assert typed(node, context, held, f"{held} D", held, "", "D") == ["", "", "", "", "pressed"]


def test_only_the_node_whose_modifiers_are_held_fires(context: RecordingContext) -> None:
    plain = ready(OnKeyboardInput, context, key_in="S")
    save = ready(OnKeyboardInput, context, key_in="S", ctrl_in=True)
    context.services.keys.press(["LeftControl", "S"])
    context.tick()
    assert (plain.compute(), save.compute()) == (None, save.pressed)


def test_a_modifier_pressed_after_the_key_does_not_release_the_key(context: RecordingContext) -> None:
    node = ready(OnKeyboardInput, context, key_in="D")
    assert typed(node, context, "D", "D LeftShift", "LeftShift") == ["pressed", "", "released"]


@pytest.mark.parametrize(("key", "others"), [("LeftShift", ""), ("RightControl", "")])
def test_a_modifier_may_be_the_key_itself(key: str, others: str, context: RecordingContext) -> None:
    node = ready(OnKeyboardInput, context, key_in=key)
    assert typed(node, context, key, "") == ["pressed", "released"]
