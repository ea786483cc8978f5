"""Nodes that log messages for users (`omni.graph.action`, `omni.graph.ui_nodes`).

If a node logs the same message again, `graphrun run` does not print it again.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, String, Token
from graphengine.nodes.checked import one_of

_SEVERITIES = {"Verbose": "info", "Info": "info", "Warn": "warning", "Warning": "warning", "Error": "error"}


class TellingNode(Node):
    """Base of nodes that log a message with the severity `logLevel`."""

    exec_in = ExecIn()
    exec_out = ExecOut()

    log: Callable[[Any, str], None] = Bound()

    def setup(self, context: Context) -> None:
        """Store the session's log function in `log`."""
        self.log = context.log

    def tell(self, level: str, text: str) -> None:
        """Log a message.

        Args:
            level: severity, the value of the input `logLevel`.
            text: the message.

        Raises:
            BadValueError: the severity is unknown.
        """
        self.log(_SEVERITIES[one_of("logLevel", level, _SEVERITIES)], text)


class LogMessage(TellingNode, type="omni.graph.action.LogMessage"):
    """Logs a message, prefixed with the node's prim path."""

    channel: Token = In(default="omni.graph.nodes_core.plugin", doc="no effect: there is only one log")
    log_level: Token = In(default="Info", tokens=("Verbose", "Info", "Warn", "Error"))
    message: String = In(default="", doc="text to log")

    def compute(self) -> None:
        """Log `message` with the severity `logLevel`.

        Raises:
            BadValueError: the value of `logLevel` is not a known severity.
        """
        self.tell(self.log_level, self.message)


class PrintText(TellingNode, type="omni.graph.ui_nodes.PrintText"):
    """Logs a text, prefixed with the node's prim path."""

    text: String = In(default="", doc="text to log")
    log_level: Token = In(default="Info", tokens=("Info", "Warning", "Error"))
    to_screen: bool = In(default=False, doc="no effect: there is no window")
    viewport: Token = In(default="", doc="no effect: there is no window")

    def compute(self) -> None:
        """Log `text` with the severity `logLevel`.

        Raises:
            BadValueError: the value of `logLevel` is not a known severity.
        """
        self.tell(self.log_level, self.text)
