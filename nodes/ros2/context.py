"""ROS 2 domains for topics and services."""

from __future__ import annotations

from graphengine.node import Bound, Context, In, Node, Out, UChar, UInt64


class ROS2Context(Node, type="isaacsim.ros2.bridge.ROS2Context"):
    """Provides the handle of a ROS 2 domain."""

    domain_id: UChar = In(
        default=0, setup=True, name="domain_id", doc="domain id if `ROS_DOMAIN_ID` is unset or not used"
    )
    use_domain_id_env_var: bool = In(
        default=True, setup=True, name="useDomainIDEnvVar", doc="use `ROS_DOMAIN_ID` as domain id, if it is set"
    )
    context: UInt64 = Out(default=0)

    handle: int = Bound()

    def setup(self, context: Context) -> None:
        """Choose the domain."""
        self.handle = context.ros_context(self.domain_id, self.use_domain_id_env_var)

    def compute(self) -> None:
        """Output the handle of the domain."""
        self.context = self.handle
