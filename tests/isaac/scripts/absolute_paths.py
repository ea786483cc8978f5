import omni.graph.core as og

og.Controller.edit(
    {"graph_path": "/World/Robots/absolute", "evaluator_name": "execution"},
    {
        og.Controller.Keys.SET_VALUES: [("/World/Robots/absolute/Wait.inputs:duration", 2)],
        og.Controller.Keys.CONNECT: [
            ("/World/Robots/absolute/Tick.outputs:tick", "/World/Robots/absolute/Wait.inputs:execIn"),
        ],
        og.Controller.Keys.CREATE_NODES: [
            ("/World/Robots/absolute/Tick", "omni.graph.action.OnPlaybackTick"),
            ("/World/Robots/absolute/Wait", "omni.graph.action.Delay"),
        ],
    },
)
