"""Quality of service as a value that publishers and subscribers take."""

from __future__ import annotations

from dataclasses import asdict

from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import PRESETS, qos_json
from graphengine.node import BadValueError, In, Node, Out, String, Token, UInt64

_DEFAULT = "defaultPubSub"
"""The reference's default, which is none of its presets and means the first of them."""


class ROS2QoSProfile(Node, type="isaacsim.ros2.bridge.ROS2QoSProfile"):
    """A quality of service as JSON: a preset, but for the policies that are set to something else than their defaults.

    Default for publishers/subscribers and Services are keepLast of 10, reliable, volatile; Sensor Data is keepLast of 5,
    bestEffort, volatile; System Default leaves all to the middleware; Custom has the policies as they are.
    """

    history: Token = In(default="keepLast", tokens=("systemDefault", "keepLast", "keepAll", "unknown"))
    depth: UInt64 = In(default=10, doc="messages that are kept, with keepLast")
    reliability: Token = In(default="reliable", tokens=("systemDefault", "reliable", "bestEffort", "unknown"))
    durability: Token = In(default="volatile", tokens=("systemDefault", "transientLocal", "volatile", "unknown"))
    deadline: float = In(default=0.0, unit="s", doc="longest time between two messages; 0 for any")
    lifespan: float = In(default=0.0, unit="s", doc="age from which on a message is not delivered; 0 for never")
    liveliness: Token = In(default="systemDefault", tokens=("systemDefault", "automatic", "manualByTopic", "unknown"))
    lease_duration: float = In(default=0.0, unit="s", doc="silence after which a writer counts as gone; 0 for never")
    create_profile: Token = In(default=_DEFAULT, tokens=(_DEFAULT, *PRESETS, "Custom"), doc="the preset")
    qos_profile: String = Out(doc="for `qosProfile` of publishers and subscribers")

    def compute(self) -> None:
        """Put the profile out."""
        policies = {name: getattr(self, name) for name in asdict(QoS())}
        unknown = [name for name, value in policies.items() if value == "unknown"]
        if unknown:
            raise BadValueError(unknown[0], "unknown", "a policy that ROS 2 has")
        if self.create_profile in PRESETS:
            changed = {name: value for name, value in policies.items() if value != type(self).fields[name].default}
            policies = asdict(PRESETS[self.create_profile]) | changed
        self.qos_profile = qos_json(QoS(**policies))
