"""Base classes of helper nodes. Helper nodes publish the samples of a sensor while the simulation plays."""

from __future__ import annotations

from typing import Any

from graphengine.devices.device import TickSensor
from graphengine.messages.endpoints import Publisher
from graphengine.node import Bound, Clock, Context, In, Token, UInt
from graphengine.nodes.ros2.publisher import TopicNode


class SensorHelper(TopicNode):
    """Base of nodes that publish a sensor's samples from the first execution of the node until the simulation stops.

    A subclass looks up the sensor in `setup` and publishes in `update`. The namespace of a topic comes from the sensor's prim and
    the ancestors of this prim.
    """

    enabled: bool = In(default=True, doc="true: an execution starts publishing; false: an execution stops publishing")
    render_product_path: Token = In(
        required=True, setup=True, doc="path from IsaacCreateRenderProduct, or prim path of the sensor"
    )
    reset_simulation_time_on_stop: bool = In(
        default=True, doc="true: stamps are the time since play; false: the time since the session began"
    )
    use_system_time: bool = In(default=False, doc="stamp with wall time; runs are then not reproducible")

    clock: Clock = Bound()

    def setup(self, context: Context) -> None:
        """Store the clock in `clock`; a subclass also looks up the sensor and creates the publisher."""
        self.clock = context.clock

    def open_for(self, context: Context, sensor: TickSensor, message_type: str, topic: str, **facts: Any) -> Publisher:
        """Create a publisher for a sensor's samples; `facts` are further keyword arguments of `Context.publisher`."""
        rate = min(sensor.rate, 1.0 / self.clock.delta) / self.samples_per_message()
        return self.open_topic(context, message_type, topic, namespace_from=sensor.prim_path, rate=rate, **facts)

    def samples_per_message(self) -> int:
        """Return n if every nth sample is published; this base class publishes every sample and returns 1."""
        return 1

    def compute(self) -> None:
        """Start publishing if `enabled` is true, otherwise stop."""
        self.active = self.enabled

    def update(self) -> None:
        """Publish the sample due in this tick, if the topic has subscribers."""
        raise NotImplementedError

    def stamp(self, time: float) -> float:
        """Return the stamp, in s, of a sample that was taken `time` seconds after play."""
        if self.use_system_time:
            return self.clock.wall_time
        if self.reset_simulation_time_on_stop:
            return time
        return time + (self.clock.monotonic_time - self.clock.time)


class SkippingHelper(SensorHelper):
    """Base of helper nodes that can skip samples."""

    frame_skip_count: UInt = In(default=0, setup=True, doc="deprecated: samples to skip after each published sample")

    def samples_per_message(self) -> int:
        """Return n if every nth sample is published: `frameSkipCount` + 1."""
        return self.frame_skip_count + 1

    def left_out(self, index: int) -> bool:
        """Return whether `frameSkipCount` skips the sample with this index."""
        return index % self.samples_per_message() != 0
