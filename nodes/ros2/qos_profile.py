"""A node that builds QoS profiles for the other ROS 2 nodes."""

from __future__ import annotations

from dataclasses import asdict

from graphengine.messages.endpoints import QoS
from graphengine.messages.qos import PRESETS, qos_json
from graphengine.node import BadValueError, In, Node, Out, String, Token, UInt64

_DEFAULT = "defaultPubSub"
"""Isaac Sim's default. It is not one of the presets; its policies are those of "Default for publishers/subscribers"."""


class ROS2QoSProfile(Node, type="isaacsim.ros2.bridge.ROS2QoSProfile"):
    """Builds a QoS profile as JSON from a preset; a policy input with a value other than its default overrides the preset.

    "Default for publishers/subscribers" and "Services" are keepLast with depth 10, reliable, volatile; "Sensor Data" is
    keepLast with depth 5, bestEffort, volatile; "System Default" leaves these policies to the middleware; "Custom" uses only
    the inputs; their defaults are the policies of the first preset.
    """

    history: Token = In(default="keepLast", tokens=("systemDefault", "keepLast", "keepAll", "unknown"))
    depth: UInt64 = In(default=10, doc="number of messages to keep if `history` is keepLast")
    reliability: Token = In(default="reliable", tokens=("systemDefault", "reliable", "bestEffort", "unknown"))
    durability: Token = In(default="volatile", tokens=("systemDefault", "transientLocal", "volatile", "unknown"))
    deadline: float = In(default=0.0, ge=0.0, unit="s", doc="maximum time between two messages; 0: no limit")
    lifespan: float = In(default=0.0, ge=0.0, unit="s", doc="age at which a message expires; 0: never")
    liveliness: Token = In(default="systemDefault", tokens=("systemDefault", "automatic", "manualByTopic", "unknown"))
    lease_duration: float = In(
        default=0.0, ge=0.0, unit="s", doc="time without sign of life after which a publisher is lost; 0: never"
    )
    create_profile: Token = In(
        default=_DEFAULT,
        tokens=(_DEFAULT, *PRESETS, "Custom"),
        doc="preset; policy inputs with values other than their defaults override it",
    )
    qos_profile: String = Out(doc="QoS profile as JSON, for `qosProfile` of other nodes")

    def compute(self) -> None:
        """Output the profile that the inputs define.

        Raises:
            BadValueError: a policy is `unknown`.
        """
        policies = {name: getattr(self, name) for name in asdict(QoS())}
        unknown = [name for name, value in policies.items() if value == "unknown"]
        if unknown:
            raise BadValueError(unknown[0], "unknown", "a policy that ROS 2 has")
        if self.create_profile in PRESETS:
            changed = {name: value for name, value in policies.items() if value != type(self).fields[name].default}
            policies = asdict(PRESETS[self.create_profile]) | changed
        self.qos_profile = qos_json(QoS(**policies))
