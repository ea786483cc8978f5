"""Text of messages from strangers, as it is printed."""

from __future__ import annotations

import pytest
import yaml

from graphengine.messages import messages
from graphengine.messages.message_text import TypedValue, to_yaml


@pytest.mark.parametrize("kind", ["\u202e", "\u2066", "\u200b", "\ufeff", "\u2028", "\u2029", "\U000e0041", "\u00ad"])
def test_characters_that_mislead_are_escapes_that_yaml_reads_back(kind: str) -> None:
    text = f"robot{kind}: ü"
    told = to_yaml(TypedValue.of(messages.String(text)))
    assert all(character.isprintable() or character == "\n" for character in told)
    assert yaml.safe_load(told) == {"data": text}
