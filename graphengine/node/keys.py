"""The keyboard that nodes read, with OmniGraph's names of the keys."""

from __future__ import annotations

import string
from collections.abc import Collection

from graphengine.format.errors import UsageError
from graphengine.format.stateful import Stateful
from graphengine.format.wording import unknown

_PUNCTUATION = {"'": "Apostrophe", "\\": "Backslash", ",": "Comma", "=": "Equal", "`": "GraveAccent"}
_PUNCTUATION |= {"[": "LeftBracket", "]": "RightBracket", "-": "Minus", ".": "Period", ";": "Semicolon"}
_PUNCTUATION |= {"/": "Slash", " ": "Space"}
_CONTROLS = {"\t": "Tab", "\r": "Enter", "\n": "Enter", "\x7f": "Backspace", "\x1b": "Escape"}
_ARROWS = {"up": "Up", "down": "Down", "left": "Left", "right": "Right"}
_TYPED: dict[str, tuple[str, ...]] = {
    **{chr(number): ("LeftControl", chr(number + 64)) for number in range(1, 27)},
    **{text: (name,) for text, name in (_PUNCTUATION | _CONTROLS | _ARROWS).items()},
    **{digit: (f"Key{digit}",) for digit in string.digits},
    **{letter.lower(): (letter,) for letter in string.ascii_uppercase},
    **{letter: ("LeftShift", letter) for letter in string.ascii_uppercase},
}
MODIFIERS = {
    "shift": ("LeftShift", "RightShift"),
    "alt": ("LeftAlt", "RightAlt"),
    "ctrl": ("LeftControl", "RightControl"),
}
_NAMED_KEYS = """
Apostrophe Backslash Backspace CapsLock Comma Del Down End Enter Equal Escape F1 F10 F11 F12 F2 F3 F4 F5 F6 F7 F8 F9
GraveAccent Home Insert Key0 Key1 Key2 Key3 Key4 Key5 Key6 Key7 Key8 Key9 Left LeftAlt LeftBracket LeftControl
LeftShift LeftSuper Menu Minus NumLock Numpad0 Numpad1 Numpad2 Numpad3 Numpad4 Numpad5 Numpad6 Numpad7 Numpad8
Numpad9 NumpadAdd NumpadDel NumpadDivide NumpadEnter NumpadEqual NumpadMultiply NumpadSubtract PageDown PageUp Pause
Period PrintScreen Right RightAlt RightBracket RightControl RightShift RightSuper ScrollLock Semicolon Slash Space
Tab Up
"""
KEYS = (*string.ascii_uppercase, *_NAMED_KEYS.split())
"""Names of all keys, in OmniGraph's order."""


class Keyboard(Stateful):
    """The keys that are held down, by their OmniGraph names. `held` and `before` change only at the beginning of a tick.

    Attributes:
        held: keys that are held down in this tick.
        before: keys that were held down in the previous tick.
        asked: whether a node of the session uses the keyboard.
    """

    kept = ("_down", "_tapped", "before", "held")

    def __init__(self) -> None:
        self.asked = False
        self.held: frozenset[str] = frozenset()
        self.before: frozenset[str] = frozenset()
        self._down: set[str] = set()
        self._tapped: set[str] = set()

    def press(self, keys: Collection[str]) -> None:
        """Hold keys down from the next tick on, until `release` is called.

        Raises:
            UsageError: a name is not the name of a key.
        """
        _expect(keys)
        self._down.update(keys)

    def release(self, keys: Collection[str]) -> None:
        """Release keys from the next tick on. A key that was pressed after the last tick began is first held for one tick.

        Raises:
            UsageError: a name is not the name of a key.
        """
        _expect(keys)
        self._tapped.update(set(keys) & (self._down - self.held))
        self._down.difference_update(keys)

    def freeze(self) -> None:
        """Begin a tick: set `before` to the keys of the previous tick and `held` to those of this tick."""
        self.before, self.held = self.held, frozenset(self._down | self._tapped)
        self._tapped.clear()

    def clear(self) -> None:
        """Empty `held` and `before`. Keys that are still down appear in `held` again at the next tick."""
        self.before = self.held = frozenset()

    def any_of(self, modifier: str) -> bool:
        """Return whether the left or right key of a modifier is held down; the modifier is `shift`, `alt` or `ctrl`."""
        return any(key in self.held for key in MODIFIERS[modifier])


def _expect(keys: Collection[str]) -> None:
    for key in keys:
        if key not in KEYS:
            raise UsageError(unknown("key", key, KEYS))


def keys_of(character: str) -> tuple[str, ...]:
    """Return the names of the keys that a user presses to type a character on a terminal; empty if no keys are known for it.

    Instead of a character, the argument can be `up`, `down`, `left` or `right` for an arrow key.
    """
    return _TYPED.get(character, ())
