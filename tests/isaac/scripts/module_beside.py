import json
import os
from pathlib import Path

import omni.graph.core as og
from robot_facts import JOINTS, graph_id

with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "robot_facts.json")) as file:
    facts = json.load(file)
assert Path(__file__).with_suffix(".py").is_file()

og.Controller.edit(
    graph_id("drive"),
    {
        og.Controller.Keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Diff", "isaacsim.robot.wheeled_robots.DifferentialController"),
            ("Move", "isaacsim.core.nodes.IsaacArticulationController"),
        ],
        og.Controller.Keys.SET_VALUES: [
            *((f"Diff.inputs:{key}", facts[key]) for key in ("wheelRadius", "wheelDistance")),
            ("Move.inputs:jointNames", JOINTS),
            ("Move.inputs:targetPrim", "/World/jetbot"),
        ],
        og.Controller.Keys.CONNECT: [
            ("Tick.outputs:tick", "Diff.inputs:execIn"),
            ("Tick.outputs:tick", "Move.inputs:execIn"),
            ("Diff.outputs:velocityCommand", "Move.inputs:velocityCommand"),
        ],
    },
)
