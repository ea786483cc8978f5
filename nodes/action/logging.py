"""Messages for people (`omni.graph.action`, `omni.graph.ui_nodes`). One that was told already is not told again."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from graphengine.node import Bound, Context, ExecIn, ExecOut, In, Node, String, Token
from graphengine.nodes.checked import one_of

_SEVERITIES = {"Verbose": "info", "Info": "info", "Warn": "warning", "Warning": "warning", "Error": "error"}


class TellingNode(Node):
    """A node that tells people something."""

    exec_in = ExecIn()
    exec_out = ExecOut()

    log: Callable[[Any, str], None] = Bound()

    def setup(self, context: Context) -> None:
        """Bind the log."""
        self.log = context.log

    def tell(self, level: str, text: str) -> None:
        """Tell a text.

        Raises:
            BadValueError: there is no such level.
        """
        self.log(_SEVERITIES[one_of("logLevel", level, _SEVERITIES)], text)


class LogMessage(TellingNode, type="omni.graph.action.LogMessage"):
    """Tells a message, with the node's path in front."""

    channel: Token = In(default="omni.graph.nodes_core.plugin", doc="means nothing here: there is one log")
    log_level: Token = In(default="Info", tokens=("Verbose", "Info", "Warn", "Error"))
    message: String = In(default="", doc="what is told")

    def compute(self) -> None:
        """Tell it.

        Raises:
            BadValueError: there is no such level.
        """
        self.tell(self.log_level, self.message)


class PrintText(TellingNode, type="omni.graph.ui_nodes.PrintText"):
    """Tells a text, with the node's path in front."""

    text: String = In(default="", doc="what is told")
    log_level: Token = In(default="Info", tokens=("Info", "Warning", "Error"))
    to_screen: bool = In(default=False, doc="means nothing here: there is no viewport")
    viewport: Token = In(default="", doc="means nothing here: there is no viewport")

    def compute(self) -> None:
        """Tell it.

        Raises:
            BadValueError: there is no such level.
        """
        self.tell(self.log_level, self.text)
