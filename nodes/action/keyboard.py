"""Keys (`omni.graph.action`, `omni.graph.nodes`).

They come from the terminal of `graphrun run`, or from `graphrun ctl press` and `release`. A terminal tells that a key was
pressed, and by repeating that it is held, but not that it was let go: that is concluded 0.6 s after the last it sent. It sends no
modifiers alone, and none with the arrows.
"""

from __future__ import annotations

from graphengine.node import Bound, Context, ExecOut, Fire, In, Keyboard, Node, Out, Token
from graphengine.node.keys import KEYS, MODIFIERS


class OnKeyboardInput(Node, type="omni.graph.action.OnKeyboardInput"):
    """Fires when a key goes down while its modifiers are held and no others, and when it or one of its modifiers goes up."""

    key_in: Token = In(default="A", tokens=KEYS)
    shift_in: bool = In(default=False, doc="whether Shift has to be held when the key goes down; else it must not be")
    alt_in: bool = In(default=False, doc="likewise Alt")
    ctrl_in: bool = In(default=False, doc="likewise Ctrl")
    only_playback: bool = In(default=True, doc="graphs run while the simulation plays, and at no other time")
    pressed = ExecOut()
    released = ExecOut()
    is_pressed: bool = Out(doc="whether pressed fired last")
    key_out: Token = Out(doc="the key, when it fires")

    keyboard: Keyboard = Bound()

    def setup(self, context: Context) -> None:
        """Bind the keyboard."""
        self.keyboard = context.keyboard()

    def compute(self) -> Fire:
        """Compare this tick with the one before."""
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


class ReadKeyboardState(Node, type="omni.graph.nodes.ReadKeyboardState", volatile=True):
    """Whether a key is held down."""

    key: Token = In(default="A", tokens=KEYS)
    is_pressed: bool = Out()
    shift_out: bool = Out()
    alt_out: bool = Out()
    ctrl_out: bool = Out()

    keyboard: Keyboard = Bound()

    def setup(self, context: Context) -> None:
        """Bind the keyboard."""
        self.keyboard = context.keyboard()

    def compute(self) -> None:
        """Look."""
        self.is_pressed = self.key in self.keyboard.held
        self.shift_out, self.alt_out, self.ctrl_out = map(self.keyboard.any_of, ("shift", "alt", "ctrl"))
