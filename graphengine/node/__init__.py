"""What the author of a node needs: the class, its ports, and what a node may ask of its context; `types` are those of ports."""

from __future__ import annotations

from graphengine.node.clock import Clock
from graphengine.node.context.context import Context
from graphengine.node.context.handles import RobotDescription
from graphengine.node.keys import Keyboard
from graphengine.node.mailbox import Mailbox
from graphengine.node.node_class import Fire, Node, Numbered, Pushes, node
from graphengine.node.port import ExecIn, ExecOut, In, Out, State
from graphengine.node.prims.stage_prims import PrimAttribute, Prims
from graphengine.node.variable import Variable

__all__ = ["Node", "ExecIn", "ExecOut", "In", "Out", "State", "node", "Fire", "Pushes", "Numbered"]
__all__ += ["Context", "Clock", "Variable", "Mailbox", "Keyboard", "Prims", "PrimAttribute", "RobotDescription"]
