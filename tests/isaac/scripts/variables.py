import omni.graph.core as og

keys = og.Controller.Keys
graph, *_ = og.Controller.edit(
    {"graph_path": "/World/variables", "evaluator_name": "execution"},
    {
        keys.CREATE_VARIABLES: [("speed", "double", 1.5), ("names", "token[]"), ("home", "double[3]", [0.0, 1.0, 2.0])],
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Read", "omni.graph.core.ReadVariable"),
            ("Write", "omni.graph.core.WriteVariable"),
        ],
        keys.SET_VALUES: [("Read.inputs:variableName", "speed"), ("Write.inputs:variableName", "speed")],
        keys.CONNECT: [("Tick.outputs:tick", "Write.inputs:execIn"), ("Read.outputs:value", "Write.inputs:value")],
    },
)
variable = og.Controller.variable("names", graph)
variable.set(graph.get_default_graph_context(), ["left", "right"])
