"""Latent nodes, which fire in a later pass than they are executed in."""

from __future__ import annotations

from graphengine.node import Bound, Clock, Context, ExecIn, ExecOut, Fire, In, Node, Out, State, String
from tests.compiler.nodes_for_tests.journal import Journaling


class Delay(Journaling, type="test.Delay"):
    """Fires when so much simulation time has passed since it was last started."""

    exec_in = ExecIn()
    duration: float = In(default=0.05)
    finished = ExecOut()
    started: float = Out()
    updates: float = Out()

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        super().setup(context)
        self.clock = context.clock

    def compute(self) -> None:
        self.started = self.clock.time
        self.active = True

    def update(self) -> Fire:
        self.updates += 1.0
        if self.clock.time - self.started < self.duration - 1e-9:
            return None
        self.active = False
        self.write("ends")
        return self.finished


class Stages(Node, type="test.Stages"):
    """In its n-th update it fires the ports that the n-th digit of `plan` has bits for."""

    exec_in = ExecIn()
    plan: String = In(default="123")
    first = ExecOut()
    second = ExecOut()

    updates: int = State(default=0)

    def compute(self) -> None:
        self.active = True
        self.updates = 0

    def update(self) -> Fire:
        bits = int(self.plan[self.updates])
        self.updates += 1
        self.active = self.updates < len(self.plan)
        return bits


class FailsLater(Node, type="test.FailsLater"):
    """Raises in its second update."""

    exec_in = ExecIn()
    updates: float = Out()

    def compute(self) -> None:
        self.active = True

    def update(self) -> Fire:
        self.updates += 1.0
        if self.updates == 2.0:
            raise RuntimeError("tired")
        return None
