import omni.graph.core as og

og.Controller.edit(
    {"graph_path": "/World/keys", "evaluator_name": "execution"},
    {
        "connect": [("Impulse.outputs:execOut", "Count.inputs:execIn")],
        "create_nodes": [("Impulse", "omni.graph.action.OnImpulseEvent"), ("Count", "omni.graph.action.Counter")],
        "set_values": ("Impulse.inputs:onlyPlayback", True),
    },
)
