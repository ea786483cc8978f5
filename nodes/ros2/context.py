"""The ROS 2 domain that endpoints live in."""

from __future__ import annotations

from graphengine.node import Bound, Context, In, Node, Out, UChar, UInt64


class ROS2Context(Node, type="isaacsim.ros2.bridge.ROS2Context"):
    """Handle of a ROS 2 domain."""

    domain_id: UChar = In(
        default=0, setup=True, name="domain_id", doc="used when the environment does not say, or is not asked"
    )
    use_domain_id_env_var: bool = In(default=True, setup=True, name="useDomainIDEnvVar", doc="ROS_DOMAIN_ID wins")
    context: UInt64 = Out(default=0)

    handle: int = Bound()

    def setup(self, context: Context) -> None:
        """Choose the domain."""
        self.handle = context.ros_context(self.domain_id, self.use_domain_id_env_var)

    def compute(self) -> None:
        """Hand it on."""
        self.context = self.handle
