"""The sensors of a robot: programs read the newest sample of each."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from graphengine.api.after_tick import AfterTick
from graphengine.api.guards import acting, reading
from graphengine.api.pictures import simulated
from graphengine.api.runner import Runner
from graphengine.devices.robot_sensors import sensors_of
from graphengine.devices.stage import Prim
from graphengine.format.errors import PrimError, UnknownEntityError
from graphengine.format.wording import unknown

if TYPE_CHECKING:
    from graphengine.physics.newest_sample import NewestSample


class RobotSensor(AfterTick):
    """A sensor of a robot, which `Robot.sensors` returns.

    The first call of `sample` requests samples, as a subscription requests messages: from then on, the session takes each sample,
    even if no graph reads the sensor. This changes neither messages nor recordings.

    Attributes:
        name: name of the sensor in `Robot.sensors`.
        kind: kind of the sensor: `lidar`, `camera`, `imu`, `range`, `radar`, `contact`, `raycast`, `light_beam`, `navsat`,
            `force_torque`, or a kind that a package adds.
        prim_path: path of the sensor's prim.
    """

    def __init__(self, runner: Runner, name: str, prim: Prim) -> None:
        self._runner = runner
        self.name = name
        self.kind = prim.kind
        self.prim_path = prim.path

    @reading
    def sample(self) -> Any:
        """Return the newest sample, with its simulation time; None before the first one that follows the first call.

        Sensors with a rate take samples at this rate, and other sensors in each tick. The sample of a camera
        arrives some ticks after its `time`, as declared by the camera's `latency`. After a reset, there is no sample.

        >>> lidar = sim.robots["dd100"].sensors["sim_lidar"]
        >>> lidar.sample() is None
        True
        >>> sim.run(0.1)
        True
        >>> scan = lidar.sample()
        >>> round(scan.time, 2), scan.ranges.shape, scan.points.shape
        (0.1, (2751,), (2751, 3))

        Returns:
            A frozen object with read-only arrays: `Scan` of a lidar, `Picture` of a camera, `ImuSample`, `RangeReading`,
            `Detections` of a radar, `ContactReading`, `RaycastReading`, `BeamReading`, `NavSatReading` or `Wrench`.

        Raises:
            UnknownEntityError: the sensor was removed with its robot.
        """
        newest = self._newest()
        self._runner.after_ticks.setdefault(self.prim_path, self)
        return newest.sample

    @acting
    def fault(
        self,
        *,
        silent: bool = False,
        dropout: float | None = None,
        delay: float | None = None,
        duration: float | None = None,
    ) -> None:
        """Let the sensor fail from the next tick on; the arguments are those of `Session.fault`.

        >>> sim.robots["dd100"].sensors["sim_lidar"].fault(silent=True, duration=2.0)
        """
        how = {"silent": silent, "dropout": dropout, "delay": delay, "duration": duration}
        self._runner.command("fault", sensor=self.prim_path, **how)

    @acting
    def mend(self) -> None:
        """End the fault of the sensor, if it has one."""
        self._runner.command("mend", sensor=self.prim_path)

    def _newest(self) -> NewestSample:
        from graphengine.physics.newest_sample import NewestSample

        simulation = simulated(self._runner.session.services.world)
        try:
            return simulation.handles.find(NewestSample, simulation.stage.find(self.prim_path))
        except PrimError as error:
            raise UnknownEntityError(f"no sensor {self.prim_path!r}: it was removed") from error

    def after_tick(self, frame: int) -> None:
        """Take the sensor's sample of this tick. The session calls this method after each tick.

        Args:
            frame: number of ticks since the start or since the last reset of the time.
        """
        try:
            self._newest().update()
        except UnknownEntityError:
            del self._runner.after_ticks[self.prim_path]

    def __repr__(self) -> str:
        return f"<RobotSensor {self.name} ({self.kind}) at {self.prim_path}>"


class Sensors(dict[str, RobotSensor]):
    """Sensors by name; an unknown name raises UnknownEntityError."""

    def __missing__(self, name: str) -> RobotSensor:
        """Raise UnknownEntityError; its message suggests similar names, or lists all names."""
        raise UnknownEntityError(unknown("sensor", name, self))


def find_sensors(runner: Runner, robot: Prim) -> Sensors:
    """Return the sensors of a robot, in the order of the robot file."""
    found = sensors_of(runner.session.services.stage, robot)
    return Sensors((name, RobotSensor(runner, name, prim)) for name, prim in found.items())
