import omni.graph.core as og

GRAPH = "/World/graph"
keys = og.Controller.Keys
og.Controller.edit({"graph_path": GRAPH, "evaluator_name": "execution"})
og.Controller.edit(GRAPH, {keys.CREATE_NODES: ("OnTick", "omni.graph.action.OnPlaybackTick")})
og.Controller.edit(GRAPH, {keys.CREATE_NODES: [("Imu", "isaacsim.sensors.physics.IsaacReadIMU")]})
og.Controller.edit(GRAPH, {keys.CREATE_NODES: [("Publish", "isaacsim.ros2.bridge.ROS2PublishImu")]})
og.Controller.edit(GRAPH, {keys.SET_VALUES: ("Imu.inputs:imuPrim", "/World/robot/imu")})
og.Controller.edit(
    GRAPH,
    {
        keys.CONNECT: [
            ("OnTick.outputs:tick", "Imu.inputs:execIn"),
            ("Imu.outputs:execOut", "Publish.inputs:execIn"),
            ("Imu.outputs:angVel", "Publish.inputs:angularVelocity"),
            ("Imu.outputs:linAcc", "Publish.inputs:linearAcceleration"),
            ("Imu.outputs:orientation", "Publish.inputs:orientation"),
        ]
    },
)
