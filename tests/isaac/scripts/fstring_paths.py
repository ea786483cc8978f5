import omni.graph.core as og
import usdrt.Sdf

ROBOT = "nova"
ROOT = f"/World/{ROBOT}"
CHASSIS = ROOT + "/chassis"
topic: str = f"{ROBOT}/odom"

keys = og.Controller.Keys
(graph, nodes, _, _) = og.Controller.edit(
    {"graph_path": f"{ROOT}/odometry", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("OnTick", "omni.graph.action.OnPlaybackTick"),
            ("Odometry", "isaacsim.core.nodes.IsaacComputeOdometry"),
            ("Publish", "isaacsim.ros2.bridge.ROS2PublishOdometry"),
        ],
        keys.SET_VALUES: [
            ("Odometry.inputs:chassisPrim", [usdrt.Sdf.Path(CHASSIS)]),
            ("Publish.inputs:topicName", topic),
        ],
        keys.CONNECT: [
            ("OnTick.outputs:tick", "Odometry.inputs:execIn"),
            ("Odometry.outputs:execOut", "Publish.inputs:execIn"),
            ("Odometry.outputs:position", "Publish.inputs:position"),
            ("Odometry.outputs:orientation", "Publish.inputs:orientation"),
        ],
    },
)
