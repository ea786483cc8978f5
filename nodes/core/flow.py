"""The event node for physics steps, and gates that count executions (`isaacsim.core.nodes`)."""

from __future__ import annotations

import math

from graphengine.node import Bound, Clock, Context, ContextError, ExecIn, ExecOut, Fire, In, Node, Out, State, UInt


class OnPhysicsStep(Node, type="isaacsim.core.nodes.OnPhysicsStep"):
    """Fires after every physics step, in a graph with `runs: physics_step`."""

    step = ExecOut(doc="fires after every physics step")
    delta_simulation_time: float = Out(unit="s", doc="duration of a physics step")
    delta_system_time: float = Out(
        unit="s", doc="in the first physics step of a tick, wall time since the previous tick; in the other steps, 0"
    )

    clock: Clock = Bound()
    last_wall_time: float = State(default=math.nan)

    def setup(self, context: Context) -> None:
        """Store the clock of the node's graph in `clock`.

        Raises:
            ContextError: the graph runs once a tick instead of at every physics step.
        """
        if context.runs != "physics_step":
            text = "the node needs a graph that runs at every physics step, but this graph runs once a tick"
            raise ContextError(text, None, "write `runs: physics_step` into the graph file, or use OnPlaybackTick")
        self.clock = context.clock

    def compute(self) -> None:
        """Output the duration of the step and the elapsed wall time."""
        now = self.clock.wall_time
        self.delta_simulation_time = self.clock.delta
        self.delta_system_time = now - self.last_wall_time if self.last_wall_time == self.last_wall_time else 0.0
        self.last_wall_time = now


class IsaacSimulationGate(Node, type="isaacsim.core.nodes.IsaacSimulationGate", gated=True, counts=True):
    """Fires at every n-th execution since play, where n is `step`."""

    exec_in = ExecIn()
    step: UInt = In(default=1, doc="executions per firing; 3: fires at the third, sixth, … execution; 0: never fires")
    exec_out = ExecOut()

    executions: int = State(default=0)

    def compute(self) -> Fire:
        """Count the execution, and fire if the count is a multiple of `step`."""
        self.executions += 1
        return self.exec_out if self.step and self.executions % self.step == 0 else None


class OgnIsaacRunOneSimulationFrame(Node, type="isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame", gated=True):
    """Fires once, at its first execution since play."""

    exec_in = ExecIn()
    step = ExecOut(doc="fires at the first execution after play")

    done: bool = State(default=False)

    def compute(self) -> Fire:
        """Fire if this is the first execution since play."""
        if self.done:
            return None
        self.done = True
        return self.step
