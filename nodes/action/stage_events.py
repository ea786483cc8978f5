"""Event nodes for play and stop, the start and end of the session, and impulses from users (`omni.graph.action`)."""

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
    """Fires at the start or at the end of play, depending on `eventName`.

    The three start events (such as `Simulation Start Play`) are equivalent: the node fires in the first tick of play. The
    three stop events (such as `Simulation Stop Play`) are equivalent too: the node fires before a stop, before a reset of the
    time, and before the session ends. At a stop event, the nodes behind `execOut` see the world as it is after the last tick;
    their messages are sent before anything is reset.

    As in Omniverse Kit, pausing and resuming do not fire the node, and `onlyPlayback` does not affect stop events. The other
    events, such as `Saved`, belong to Isaac Sim's editor and never occur.
    """

    event_name: Token = In(default="Animation Start Play", tokens=_NAMES)
    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    exec_out = ExecOut()

    started: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire in the first tick of play if `eventName` is a start event."""
        first, self.started = not self.started, True
        return self.exec_out if first and self.event_name in STARTS else None

    def at_stop(self) -> Fire:
        """Fire at the end of play if `eventName` is a stop event."""
        return self.exec_out if self.event_name in STOPS else None


@lint("W101")
def lint_events_that_never_come(context: LintContext) -> None:
    """Warn about OnStageEvent nodes that wait for an event of the editor: such an event, for example `Saved`, never occurs."""
    for _, instance, node in context.nodes(OnStageEvent):
        if node.event_name not in STARTS + STOPS:
            message = f"{instance.id} never fires: {node.event_name!r} is an event of the editor"
            remedy = "use a start or stop event, such as 'Simulation Start Play' or 'Simulation Stop Play'"
            place = instance.entry.span("inputs", "eventName")
            context.findings.add("W101", message, place, remedy, related=instance.entry.via)


class OnLoaded(ClockNode, type="omni.graph.action.OnLoaded", gated=True):
    """Fires once, in the first tick of the session. It does not fire again when the simulation stops and plays again."""

    exec_out = ExecOut()

    def compute(self) -> Fire:
        """Fire if this is the first tick of the session."""
        return self.exec_out if self.clock.monotonic_time < 1.5 * self.clock.delta else None


class OnClosing(Node, type="omni.graph.action.OnClosing", gated=True):
    """Fires before its graph is closed: after all stop events at the end of the session, or when the graph's robot is removed."""

    exec_out = ExecOut()

    def at_close(self) -> Fire:
        """Fire; the engine calls this method before it closes the graph."""
        return self.exec_out


class OnImpulseEvent(Node, type="omni.graph.action.OnImpulseEvent", gated=True):
    """Fires in the tick after `graphrun ctl impulse NODE`. Several impulses before the same tick fire the node only once."""

    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    exec_out = ExecOut()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        """Create a mailbox on the queue of impulses for this node."""
        self.mailbox = context.mailbox(f"{IMPULSE}{context.prim_path}")

    def compute(self) -> Fire:
        """Fire if an impulse arrived since the previous tick."""
        return self.exec_out if self.mailbox.take() else None
