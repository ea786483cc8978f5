import omni.graph.core as og

keys = og.Controller.Keys
(graph, (tick, twist), _, _) = og.Controller.edit(
    {"graph_path": "/ActionGraph", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
            ("SubscribeTwist", "isaacsim.ros2.bridge.ROS2SubscribeTwist"),
        ],
        keys.CONNECT: ("OnPlaybackTick.outputs:tick", "SubscribeTwist.inputs:execIn"),
    },
)
og.Controller.set(og.Controller.attribute("/ActionGraph/SubscribeTwist.inputs:topicName"), "robot/cmd_vel")
og.Controller.set(attribute=og.Controller.attribute(("inputs:queueSize", twist)), value=1)
og.Controller(og.Controller.attribute("inputs:nodeNamespace", twist)).set("fleet")
og.Controller.attribute("/ActionGraph/SubscribeTwist.inputs:qosProfile").set("")
