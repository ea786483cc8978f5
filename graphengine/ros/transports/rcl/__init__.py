"""The transport `rclpy`, which uses an installed ROS 2."""

from graphengine.ros.transport import JoinOptions, Transport, TransportKind


def missing() -> str | None:
    """Return the reason why rclpy cannot be used, such as another Python version; None if it can be used."""
    from graphengine.ros.transports.rcl import installation

    return installation.missing()


def _not_for_auto() -> str | None:
    from graphengine.ros.transports.rcl import installation

    return "it is from PyPI: --transport rclpy uses it" if installation.is_from_wheels() else None


def _open(options: JoinOptions) -> Transport:
    from graphengine.ros.transports.rcl.rcl import RclTransport

    return RclTransport(options)


TRANSPORT = TransportKind(
    "rclpy",
    "ROS 2 programs through rclpy of an installed ROS 2",
    _open,
    auto=1,
    missing=missing,
    not_for_auto=_not_for_auto,
)
