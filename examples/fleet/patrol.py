"""An example of a user-defined node: `Patrol` computes a speed that drives a robot back and forth."""

from graphengine.node import ExecIn, ExecOut, In, Node, Out, State


class Patrol(Node, type="patrol.Patrol"):
    """Outputs a speed whose sign changes each time a leg of the patrol has been driven."""

    exec_in = ExecIn()
    dt: float = In(default=0.0, ge=0.0, unit="s", doc="time since the last tick")
    speed: float = In(default=0.5, unit="m/s")
    leg: float = In(default=2.0, gt=0.0, unit="s", doc="duration of a leg, after which the robot reverses")
    velocity: float = Out(unit="m/s")
    exec_out = ExecOut()

    elapsed: float = State(default=0.0)

    def compute(self) -> None:
        """Output `speed` during the first leg, `-speed` during the second, and so on."""
        self.velocity = self.speed if self.elapsed % (2 * self.leg) < self.leg else -self.speed
        self.elapsed += self.dt
