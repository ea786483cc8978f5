"""A node of one's own: it drives a robot back and forth."""

from graphengine.node import ExecIn, ExecOut, In, Node, Out, State


class Patrol(Node, type="patrol.Patrol"):
    """A speed whose sign changes with each leg."""

    exec_in = ExecIn()
    dt: float = In(default=0.0, ge=0.0, unit="s", doc="time since the last tick")
    speed: float = In(default=0.5, unit="m/s")
    leg: float = In(default=2.0, gt=0.0, unit="s", doc="time between two turns")
    velocity: float = Out(unit="m/s")
    exec_out = ExecOut()

    elapsed: float = State(default=0.0)

    def compute(self) -> None:
        """Turn when a leg is over."""
        self.velocity = self.speed if self.elapsed % (2 * self.leg) < self.leg else -self.speed
        self.elapsed += self.dt
