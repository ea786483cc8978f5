import omni.graph.core as og

og.Controller.edit(
    {"graph_path": "/World/custom", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Gripper", "isaacsim.robot.surface_gripper.SurfaceGripper"),
            ("Mine", "my_company.nodes.Blinker"),
        ],
        og.Controller.Keys.CONNECT: [
            ("Tick.outputs:tick", "Gripper.inputs:Close"),
            ("Tick.outputs:tick", "Mine.inputs:execIn"),
            ("Mine.inputs:rate", "Gripper.inputs:Speed"),
        ],
        og.Controller.Keys.SET_VALUES: [("Mine.inputs:rate", 2.0)],
    },
)
