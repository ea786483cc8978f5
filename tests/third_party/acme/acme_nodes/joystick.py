"""What Acme's joysticks need."""

from __future__ import annotations

from graphengine.node import ExecIn, ExecOut, Fire, In, Node, Out, State


class Deadband(Node, type="acme.Deadband"):
    """A command of which what is small counts as zero."""

    command: float = In(default=0.0, doc="what the stick says")
    dead_width: float = In(default=0.1, ge=0, doc="what is smaller is zero")
    value: float = Out(doc="the command, or 0")

    def compute(self) -> None:
        """Compare."""
        self.value = 0.0 if abs(self.command) < self.dead_width else self.command


class ButtonEdge(Node, type="acme.ButtonEdge", gated=True):
    """Fires when a button that was up is down."""

    exec_in = ExecIn()
    is_down: bool = In(default=False)
    exec_out = ExecOut()
    press_count: int = Out()

    was_down: bool = State(default=False)

    def compute(self) -> Fire:
        """Compare with the execution before."""
        pressed = self.is_down and not self.was_down
        self.was_down = self.is_down
        self.press_count += pressed
        return self.exec_out if pressed else None
