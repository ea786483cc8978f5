"""Events of the session: its beginning, its plays, and impulses from outside (`omni.graph.action`)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from graphengine.context import Clock, Context, Mailbox
from graphengine.mailbox import IMPULSE
from graphengine.node import ExecOut, Fire, In, Node, State
from graphengine.registry import lint
from graphengine.types import Token

if TYPE_CHECKING:
    from graphengine.check import LintContext

STARTS = ("OmniGraph Start Play", "Simulation Start Play", "Animation Start Play")
_STOPS = ("OmniGraph Stop Play", "Simulation Stop Play", "Animation Stop Play")
_STARTS_AND_STOPS = (name for pair in zip(STARTS, _STOPS, strict=True) for name in pair)
_NAMES = ("Saved", "Selection Changed", "Hierarchy Changed", *_STARTS_AND_STOPS)


class OnStageEvent(Node, type="omni.graph.action.OnStageEvent", gated=True):
    """Fires in the first tick of a play: the session's first, and that after each stop or reset of the time.

    All three events of a start are one here. A pause ends no play, so going on after one is no start. Graphs run in ticks alone,
    so what happens at a stop, or to a stage in an editor, never reaches a graph.
    """

    event_name: Token = In(default="Animation Start Play", tokens=_NAMES)
    only_playback: bool = In(default=True, doc="graphs run while the simulation plays, and at no other time")
    exec_out = ExecOut()

    started: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire once a play."""
        first, self.started = not self.started, True
        return self.exec_out if first and self.event_name in STARTS else None


@lint("W101")
def lint_events_that_never_come(context: LintContext) -> None:
    """Events that a graph waits for in vain."""
    for plan in context.graphs:
        for instance in plan.graph.instances:
            node = instance.node
            if isinstance(node, OnStageEvent) and node.event_name not in STARTS:
                context.findings.add(
                    "W101",
                    f"{instance.id} never fires: {node.event_name!r} is no event of a tick",
                    instance.entry.span("inputs", "eventName"),
                    "graphs run in ticks, which there are none of while the simulation stands; "
                    "what comes is the start of a play, such as 'Simulation Start Play'",
                    related=instance.entry.via,
                )


class OnLoaded(Node, type="omni.graph.action.OnLoaded", gated=True):
    """Fires in the session's very first tick, and not again after a stop."""

    exec_out = ExecOut()

    clock: Clock = State()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock

    def compute(self) -> Fire:
        """Compare the time of all plays with that of one tick."""
        return self.exec_out if self.clock.monotonic_time < 1.5 * self.clock.delta else None


class OnImpulseEvent(Node, type="omni.graph.action.OnImpulseEvent", gated=True):
    """Fires in the tick after `graphrun ctl impulse NODE`; several before one tick are one."""

    only_playback: bool = In(default=True, doc="graphs run while the simulation plays, and at no other time")
    exec_out = ExecOut()

    mailbox: Mailbox = State()

    def setup(self, context: Context) -> None:
        """Bind the node's own queue."""
        self.mailbox = context.mailbox(f"{IMPULSE}{context.prim_path}")

    def compute(self) -> Fire:
        """Look whether there was one."""
        return self.exec_out if self.mailbox.take() else None
