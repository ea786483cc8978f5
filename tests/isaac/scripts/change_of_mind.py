import omni.graph.core as og

GRAPH = "/World/changed"
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": GRAPH, "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Old", "omni.graph.action.FlipFlop"),
            ("Counter", "omni.graph.action.Counter"),
            ("Twist", "isaacsim.ros2.bridge.ROS2SubscribeTwist"),
        ],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Old.inputs:execIn"),
            ("Old.outputs:a", "Counter.inputs:execIn"),
            ("Tick.outputs:tick", "Twist.inputs:execIn"),
            ("Tick.outputs:tick", "Counter.inputs:reset"),
        ],
    },
)
og.Controller.edit(
    GRAPH,
    {
        keys.CONNECT: [("Tick.outputs:tick", "Counter.inputs:execIn")],
        keys.DELETE_NODES: ["Old"],
        keys.DISCONNECT: [("Tick.outputs:tick", "Twist.inputs:execIn")],
        keys.DISCONNECT_ALL: ["Counter.inputs:reset"],
    },
)
og.Controller.delete_node(f"{GRAPH}/Twist")
