"""Nodes that read the keyboard (`omni.graph.action`, `omni.graph.nodes`).

Keys come from the terminal of `graphrun run`, or from `graphrun ctl press` and `graphrun ctl release`. A terminal reports the
press of a key and repeats the report while the key is held. It does not report the release, so a key counts as released 0.6 s
after the last report. A terminal reports a modifier only together with another key, and not together with an arrow key.
"""

from __future__ import annotations

from graphengine.node import Bound, Context, ExecOut, Fire, In, Keyboard, Node, Out, Token
from graphengine.node.keys import KEYS, MODIFIERS


class KeyboardNode(Node):
    """Base of nodes that read the keyboard."""

    keyboard: Keyboard = Bound()

    def setup(self, context: Context) -> None:
        """Store the keyboard of the session in `keyboard`."""
        self.keyboard = context.keyboard()


class OnKeyboardInput(KeyboardNode, type="omni.graph.action.OnKeyboardInput"):
    """Fires `pressed` when the key `keyIn` is pressed, and `released` when this key or a required modifier is released.

    `shiftIn`, `altIn` and `ctrlIn` select the required modifiers. A press counts only if all required modifiers, and no other
    modifiers, are held.
    """

    key_in: Token = In(default="A", tokens=KEYS)
    shift_in: bool = In(default=False, doc="true: Shift must be held when the key is pressed; false: must not")
    alt_in: bool = In(default=False, doc="true: Alt must be held when the key is pressed; false: must not")
    ctrl_in: bool = In(default=False, doc="true: Ctrl must be held when the key is pressed; false: must not")
    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    pressed = ExecOut()
    released = ExecOut()
    is_pressed: bool = Out(doc="true if the last event was a press, false if it was a release")
    key_out: Token = Out(doc="key that was last pressed")

    def compute(self) -> Fire:
        """Compare the keys held in this tick with the keys held in the previous tick, and fire on a press or a release."""
        keyboard = self.keyboard
        wanted = {"shift": self.shift_in, "alt": self.alt_in, "ctrl": self.ctrl_in}
        wanted = {modifier: needed for modifier, needed in wanted.items() if self.key_in not in MODIFIERS[modifier]}
        held = {modifier: keyboard.any_of(modifier) for modifier in wanted}
        down = self.key_in in keyboard.held
        if self.is_pressed and not (down and all(held[modifier] for modifier, needed in wanted.items() if needed)):
            self.is_pressed = False
            return self.released
        if down and held == wanted and self.key_in not in keyboard.before:
            self.is_pressed, self.key_out = True, self.key_in
            return self.pressed
        return None


class ReadKeyboardState(KeyboardNode, type="omni.graph.nodes.ReadKeyboardState", volatile=True):
    """Outputs whether the key `key` is held down, and whether the modifiers Shift, Alt and Ctrl are held down."""

    key: Token = In(default="A", tokens=KEYS)
    is_pressed: bool = Out()
    shift_out: bool = Out()
    alt_out: bool = Out()
    ctrl_out: bool = Out()

    def compute(self) -> None:
        """Output the current state of the key and of the modifiers."""
        self.is_pressed = self.key in self.keyboard.held
        self.shift_out, self.alt_out, self.ctrl_out = map(self.keyboard.any_of, ("shift", "alt", "ctrl"))
