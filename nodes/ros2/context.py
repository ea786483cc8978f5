"""A node that selects the ROS 2 domain of other nodes' topics, services and actions."""

from __future__ import annotations

from graphengine.node import Bound, Context, In, Node, Out, UChar, UInt64


class ROS2Context(Node, type="isaacsim.ros2.bridge.ROS2Context"):
    """Outputs the handle of a ROS 2 domain, for the input `context` of other ROS 2 nodes."""

    domain_id: UChar = In(
        default=0, le=232, setup=True, name="domain_id", doc="domain ID, unless that of the environment is used"
    )
    use_domain_id_env_var: bool = In(
        default=True, setup=True, name="useDomainIDEnvVar", doc="use the environment variable `ROS_DOMAIN_ID`, if set"
    )
    context: UInt64 = Out(default=0)

    handle: int = Bound()

    def setup(self, context: Context) -> None:
        """Select the domain and keep its handle."""
        self.handle = context.ros_context(self.domain_id, self.use_domain_id_env_var)

    def compute(self) -> None:
        """Output the handle of the domain."""
        self.context = self.handle
