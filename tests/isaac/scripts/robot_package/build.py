import omni.graph.core as og

from ..common.logs import info
from . import TICK
from . import types as names
from .types import clock

info("building")
og.Controller.edit(
    {"graph_path": "/World/relative", "evaluator_name": "execution"},
    {
        "create_nodes": [("tick", TICK), ("clock", clock()), ("other", names.clock())],
        "connect": [("tick.outputs:tick", "clock.inputs:execIn"), ("tick.outputs:tick", "other.inputs:execIn")],
        "set_values": [("other.inputs:topicName", "clock_too")],
    },
)
