"""The API for authors of nodes: the Node class, ports, port types, the context and exceptions."""

from __future__ import annotations

from graphengine.format.errors import BadValueError, ContextError
from graphengine.node import types
from graphengine.node.clock import Clock
from graphengine.node.context.context import Context
from graphengine.node.context.device_access import RobotDescription
from graphengine.node.keys import Keyboard
from graphengine.node.mailbox import Mailbox
from graphengine.node.node_class import Node, Numbered, node
from graphengine.node.port import Bound, ExecIn, ExecOut, Fire, In, Out, Pushes, State
from graphengine.node.prims.stage_prims import PrimAttribute, Prims
from graphengine.node.types import *  # noqa: F403  # the module lists what authors write
from graphengine.node.variable import Variable

__all__ = ["Node", "ExecIn", "ExecOut", "In", "Out", "State", "Bound", "node", "Fire", "Pushes", "Numbered"]
__all__ += ["Context", "Clock", "Variable", "Mailbox", "Keyboard", "Prims", "PrimAttribute", "RobotDescription"]
__all__ += ["BadValueError", "ContextError"]
__all__ += types.__all__
