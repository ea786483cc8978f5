import omni.graph.core as og

keys = og.Controller.Keys
graph, (tick, clock), _, _ = og.Controller.edit(
    {"graph_path": "/World/single", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ],
        keys.CONNECT: ("Tick.outputs:tick", "Clock.inputs:execIn"),
    },
)
og.Controller.edit(
    graph,
    {
        keys.CONNECT: (("outputs:time", tick), ("inputs:timeStamp", clock)),
        keys.SET_VALUES: (("inputs:topicName", clock), "time"),
    },
)
