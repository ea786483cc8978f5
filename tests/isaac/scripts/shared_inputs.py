import omni.graph.core as og

keys = og.Controller.Keys
CLOCK = "isaacsim.ros2.bridge.ROS2PublishClock"
INNER = {
    keys.CREATE_NODES: [("First", CLOCK), ("Second", CLOCK)],
    keys.PROMOTE_ATTRIBUTES: [
        (f"{node}.inputs:{port}", f"inputs:{port}")
        for node in ("First", "Second")
        for port in ("execIn", "timeStamp", "topicName")
    ],
}
og.Controller.edit(
    {"graph_path": "/World/shared", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [("Tick", "omni.graph.action.OnPlaybackTick"), ("Clocks", INNER)],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Clocks.inputs:execIn"),
            ("Tick.outputs:time", "Clocks.inputs:timeStamp"),
        ],
        keys.SET_VALUES: ("Clocks.inputs:topicName", "time"),
    },
)
