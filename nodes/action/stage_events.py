"""Events of the session: its beginning and end, its plays, and impulses from outside (`omni.graph.action`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphengine.compiler.lint_registry import lint
from graphengine.node import Bound, Context, ExecOut, Fire, In, Mailbox, Node, State, Token
from graphengine.node.mailbox import IMPULSE
from graphengine.nodes.clocked import ClockNode

if TYPE_CHECKING:
    from graphengine.compiler.lint_registry import LintContext

STARTS = ("OmniGraph Start Play", "Simulation Start Play", "Animation Start Play")
STOPS = ("OmniGraph Stop Play", "Simulation Stop Play", "Animation Stop Play")
_STARTS_AND_STOPS = (name for pair in zip(STARTS, STOPS, strict=True) for name in pair)
_NAMES = ("Saved", "Selection Changed", "Hierarchy Changed", *_STARTS_AND_STOPS)


class OnStageEvent(Node, type="omni.graph.action.OnStageEvent", gated=True):
    """Fires where a play starts, in its first tick, or where it stops: before a stop, a reset of the time, or the session's end.

    All three events of a start are one here, and so are those of a stop. As in Kit a pause is no stop, and going on after one is
    no start; a stop fires whether the graph is for playback only or not. What it fires sees the world as the last tick left it,
    and its messages leave before anything is reset. What happens to a stage in an editor never reaches a graph.
    """

    event_name: Token = In(default="Animation Start Play", tokens=_NAMES)
    only_playback: bool = In(default=True, doc="graphs run while the simulation plays, and at no other time")
    exec_out = ExecOut()

    started: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire once a play."""
        first, self.started = not self.started, True
        return self.exec_out if first and self.event_name in STARTS else None

    def at_stop(self) -> Fire:
        """Fire at the end of a play."""
        return self.exec_out if self.event_name in STOPS else None


@lint("W101")
def lint_events_that_never_come(context: LintContext) -> None:
    """Events that a graph waits for in vain."""
    for _, instance, node in context.nodes(OnStageEvent):
        if node.event_name not in STARTS + STOPS:
            message = f"{instance.id} never fires: {node.event_name!r} is an event of editors"
            remedy = "what comes is the start and the stop of a play, such as 'Simulation Start Play'"
            place = instance.entry.span("inputs", "eventName")
            context.findings.add("W101", message, place, remedy, related=instance.entry.via)


class OnLoaded(ClockNode, type="omni.graph.action.OnLoaded", gated=True):
    """Fires in the session's very first tick, and not again after a stop."""

    exec_out = ExecOut()

    def compute(self) -> Fire:
        """Compare the time of all plays with that of one tick."""
        return self.exec_out if self.clock.monotonic_time < 1.5 * self.clock.delta else None


class OnClosing(Node, type="omni.graph.action.OnClosing", gated=True):
    """Fires before its graph is closed: at the end of the session, after the stop of its play, or where its robot is removed."""

    exec_out = ExecOut()

    def at_close(self) -> Fire:
        """Fire, once."""
        return self.exec_out


class OnImpulseEvent(Node, type="omni.graph.action.OnImpulseEvent", gated=True):
    """Fires in the tick after `graphrun ctl impulse NODE`; several before one tick are one."""

    only_playback: bool = In(default=True, doc="graphs run while the simulation plays, and at no other time")
    exec_out = ExecOut()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        """Bind the node's own queue."""
        self.mailbox = context.mailbox(f"{IMPULSE}{context.prim_path}")

    def compute(self) -> Fire:
        """Look whether there was one."""
        return self.exec_out if self.mailbox.take() else None
