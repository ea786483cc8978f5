"""The transport `rclpy`, which uses an installed ROS 2."""

import importlib

from graphengine.ros.transport import JoinOptions, Transport, TransportKind


def import_error() -> str | None:
    """Return the reason why rclpy cannot be imported, such as another Python version; None if it can be imported."""
    try:
        for module in ("rclpy.executors", "rclpy.node"):
            importlib.import_module(module)
    except Exception as error:
        if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
            return "no ROS 2 is sourced"
        return f"{type(error).__name__}: {error}".splitlines()[0]
    return None


def _open(options: JoinOptions) -> Transport:
    from graphengine.ros.transports.rcl.rcl import RclTransport

    return RclTransport(options)


TRANSPORT = TransportKind(
    "rclpy", "ROS 2 programs through a sourced ROS 2 installation", _open, auto=1, missing=import_error
)
