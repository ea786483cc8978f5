import argparse

import omni.graph.core as og

parser = argparse.ArgumentParser()
parser.add_argument("--robot", default="/World/robot")
parser.add_argument("--rate", type=int, required=True)
args, unknown = parser.parse_known_args()

keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": f"{args.robot}/gate", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Gate", "isaacsim.core.nodes.IsaacSimulationGate"),
        ],
        keys.CONNECT: [("Tick.outputs:tick", "Gate.inputs:execIn")],
        keys.SET_VALUES: [("Gate.inputs:step", args.rate)],
    },
)
