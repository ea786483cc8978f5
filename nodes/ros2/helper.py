"""What the helpers of sensors have in common: they publish samples for as long as the simulation plays."""

from __future__ import annotations

from typing import Any

from graphengine.devices.device import TickSensor
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Clock, Context, In, Token, UInt
from graphengine.nodes.ros2.publisher import TopicNode


class SensorHelper(TopicNode):
    """Publishes from its first execution until stop; a subclass binds the sensor in `setup` and sends in `update`.

    Topics' namespaces are collected from the sensor's prim.
    """

    enabled: bool = In(default=True, doc="when false, an execution ends the publishing")
    render_product_path: Token = In(
        required=True, setup=True, doc="of IsaacCreateRenderProduct, or the prim path of the sensor"
    )
    reset_simulation_time_on_stop: bool = In(default=True, doc="stamps count from play; else over stop and play")
    use_system_time: bool = In(default=False, doc="stamps are wall time, and no two runs are alike")
    frame_skip_count: UInt = In(default=0, setup=True, doc="deprecated: samples to leave out after each one")

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Bind the clock."""
        self.clock = context.clock

    def open_for(self, context: Context, sensor: TickSensor, message_type: str, topic: str, **facts: Any) -> Publisher:
        """A topic for a sensor's samples; `facts` as for `Context.publisher`."""
        rate = min(sensor.rate, 1.0 / self.clock.delta) / (self.frame_skip_count + 1)
        return self.open_topic(context, message_type, topic, namespace_from=sensor.prim_path, rate=rate, **facts)

    def compute(self) -> None:
        """Begin, or end, to publish."""
        self.active = self.enabled

    def update(self) -> None:
        """Publish what is due in this tick and wanted."""
        raise NotImplementedError

    def left_out(self, index: int) -> bool:
        """Whether `frameSkipCount` leaves out the sample of that number, which then need not be taken."""
        return index % (self.frame_skip_count + 1) != 0

    def stamp(self, time: float) -> float:
        """What the header of a sample says that was taken at a time since play, s."""
        if self.use_system_time:
            return self.clock.wall_time
        if self.reset_simulation_time_on_stop:
            return time
        return time + (self.clock.monotonic_time - self.clock.time)
