import omni.graph.core as og

keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/compound", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            (
                "Doubled",
                {
                    keys.CREATE_NODES: [
                        ("Two", "omni.graph.nodes.ConstantDouble"),
                        ("Multiply", "omni.graph.nodes.Multiply"),
                    ],
                    keys.SET_VALUES: [("Two.inputs:value", 2.0)],
                    keys.CONNECT: [("Two.inputs:value", "Multiply.inputs:b")],
                    keys.PROMOTE_ATTRIBUTES: [
                        ("Multiply.inputs:a", "inputs:value"),
                        ("Multiply.outputs:product", "outputs:result"),
                    ],
                },
            ),
            ("Diff", "isaacsim.robot.wheeled_robots.DifferentialController"),
        ],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Diff.inputs:execIn"),
            ("Tick.outputs:deltaSeconds", "Doubled.inputs:value"),
            ("Doubled.outputs:result", "Diff.inputs:dt"),
        ],
        keys.SET_VALUES: [("Diff.inputs:wheelRadius", 0.1), ("Diff.inputs:wheelDistance", 0.5)],
    },
)
