"""Events of the session: start, end, play, stop, and impulses from users (`omni.graph.action`)."""

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

    A start event fires in the first tick after play. A stop event fires before a stop, before a reset of the time, and before
    the session ends. The three start events are equivalent, and so are the three stop events. As in Kit, pausing and resuming
    fire nothing, and `onlyPlayback` does not affect stop events. The nodes that a stop event fires see the world as it is
    after the last tick; their messages are sent before anything is reset. Editor events, such as `Saved`, never occur.
    """

    event_name: Token = In(default="Animation Start Play", tokens=_NAMES)
    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    exec_out = ExecOut()

    started: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire a start event in the first tick after play."""
        first, self.started = not self.started, True
        return self.exec_out if first and self.event_name in STARTS else None

    def at_stop(self) -> Fire:
        """Fire a stop event at the end of play."""
        return self.exec_out if self.event_name in STOPS else None


@lint("W101")
def lint_events_that_never_come(context: LintContext) -> None:
    """Warn of stage events that never occur."""
    for _, instance, node in context.nodes(OnStageEvent):
        if node.event_name not in STARTS + STOPS:
            message = f"{instance.id} never fires: {node.event_name!r} is an event of editors"
            remedy = "events that occur are the start and the stop of a play, such as 'Simulation Start Play'"
            place = instance.entry.span("inputs", "eventName")
            context.findings.add("W101", message, place, remedy, related=instance.entry.via)


class OnLoaded(ClockNode, type="omni.graph.action.OnLoaded", gated=True):
    """Fires once, in the first tick of the session; a stop and another play do not fire it again."""

    exec_out = ExecOut()

    def compute(self) -> Fire:
        """Fire if this is the first tick of the session."""
        return self.exec_out if self.clock.monotonic_time < 1.5 * self.clock.delta else None


class OnClosing(Node, type="omni.graph.action.OnClosing", gated=True):
    """Fires before its graph is closed: at the end of the session, after the stop events, or when its robot is removed."""

    exec_out = ExecOut()

    def at_close(self) -> Fire:
        """Fire before the graph is closed."""
        return self.exec_out


class OnImpulseEvent(Node, type="omni.graph.action.OnImpulseEvent", gated=True):
    """Fires in the tick after `graphrun ctl impulse NODE`, only once if several impulses arrive before the tick."""

    only_playback: bool = In(default=True, doc="no effect: graphs run only while the simulation plays")
    exec_out = ExecOut()

    mailbox: Mailbox = Bound()

    def setup(self, context: Context) -> None:
        """Bind the queue of the node's impulses."""
        self.mailbox = context.mailbox(f"{IMPULSE}{context.prim_path}")

    def compute(self) -> Fire:
        """Fire if an impulse arrived."""
        return self.exec_out if self.mailbox.take() else None
