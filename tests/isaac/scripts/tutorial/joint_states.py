import omni.graph.core as og
import omni.usd
from pxr import Sdf

CHASSIS = "/dd100/Geometry/base_link/chassis_link"
LIDAR = f"{CHASSIS}/sim_lidar"
PATH = f"{CHASSIS}/joint_states"
stage = omni.usd.get_context().get_stage()
if stage.GetPrimAtPath(PATH):
    stage.RemovePrim(PATH)
k = og.Controller.Keys
og.Controller.edit(
    {"graph_path": PATH, "evaluator_name": "execution"},
    {
        k.CREATE_NODES: [
            ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
            ("ReadSimTime", "isaacsim.core.nodes.IsaacReadSimulationTime"),
            ("Context", "isaacsim.ros2.bridge.ROS2Context"),
            ("PublishJointState", "isaacsim.ros2.bridge.ROS2PublishJointState"),
            ("ComputeOdom", "isaacsim.core.nodes.IsaacComputeOdometry"),
            ("PublishOdom", "isaacsim.ros2.bridge.ROS2PublishOdometry"),
            ("PublishRawTF", "isaacsim.ros2.bridge.ROS2PublishRawTransformTree"),
            ("ComputeTransformTree", "isaacsim.core.nodes.IsaacComputeTransformTree"),
            ("PublishTF", "isaacsim.ros2.bridge.ROS2PublishTransformTree"),
        ],
        k.SET_VALUES: [
            ("PublishJointState.inputs:topicName", "platform/joint_states"),
            ("PublishJointState.inputs:targetPrim", [Sdf.Path(CHASSIS)]),
            ("ComputeOdom.inputs:chassisPrim", [Sdf.Path(CHASSIS)]),
            ("PublishOdom.inputs:odomFrameId", "odom"),
            ("PublishOdom.inputs:topicName", "odom"),
            ("PublishRawTF.inputs:parentFrameId", "odom"),
            ("PublishRawTF.inputs:childFrameId", "base_link"),
            ("ComputeTransformTree.inputs:parentPrim", Sdf.Path(CHASSIS)),
            ("ComputeTransformTree.inputs:targetPrims", [Sdf.Path(LIDAR)]),
            ("PublishTF.inputs:staticPublisher", True),
            ("PublishTF.inputs:topicName", "tf_static"),
        ],
        k.CONNECT: [
            ("OnPlaybackTick.outputs:tick", "PublishJointState.inputs:execIn"),
            ("ReadSimTime.outputs:simulationTime", "PublishJointState.inputs:timeStamp"),
            ("OnPlaybackTick.outputs:tick", "ComputeOdom.inputs:execIn"),
            ("ComputeOdom.outputs:execOut", "PublishOdom.inputs:execIn"),
            ("ComputeOdom.outputs:angularVelocity", "PublishOdom.inputs:angularVelocity"),
            ("ComputeOdom.outputs:linearVelocity", "PublishOdom.inputs:linearVelocity"),
            ("ComputeOdom.outputs:orientation", "PublishOdom.inputs:orientation"),
            ("ComputeOdom.outputs:position", "PublishOdom.inputs:position"),
            ("ReadSimTime.outputs:simulationTime", "PublishOdom.inputs:timeStamp"),
            ("OnPlaybackTick.outputs:tick", "PublishRawTF.inputs:execIn"),
            ("ComputeOdom.outputs:orientation", "PublishRawTF.inputs:rotation"),
            ("ComputeOdom.outputs:position", "PublishRawTF.inputs:translation"),
            ("ReadSimTime.outputs:simulationTime", "PublishRawTF.inputs:timeStamp"),
            ("OnPlaybackTick.outputs:tick", "ComputeTransformTree.inputs:execIn"),
            ("ComputeTransformTree.outputs:execOut", "PublishTF.inputs:execIn"),
            ("ComputeTransformTree.outputs:childFrames", "PublishTF.inputs:childFrames"),
            ("ComputeTransformTree.outputs:orientations", "PublishTF.inputs:orientations"),
            ("ComputeTransformTree.outputs:parentFrames", "PublishTF.inputs:parentFrames"),
            ("ComputeTransformTree.outputs:translations", "PublishTF.inputs:translations"),
            ("ReadSimTime.outputs:simulationTime", "PublishTF.inputs:timeStamp"),
            ("Context.outputs:context", "PublishJointState.inputs:context"),
            ("Context.outputs:context", "PublishOdom.inputs:context"),
            ("Context.outputs:context", "PublishRawTF.inputs:context"),
            ("Context.outputs:context", "PublishTF.inputs:context"),
        ],
    },
)
