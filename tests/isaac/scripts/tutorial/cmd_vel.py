import omni.graph.core as og
import omni.usd
from pxr import Sdf

ROBOT = "/dd100"
PATH = f"{ROBOT}/Geometry/base_link/chassis_link/cmd_vel"
stage = omni.usd.get_context().get_stage()
if stage.GetPrimAtPath(PATH):
    stage.RemovePrim(PATH)
k = og.Controller.Keys
og.Controller.edit(
    {"graph_path": PATH, "evaluator_name": "execution"},
    {
        k.CREATE_NODES: [
            ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
            ("Context", "isaacsim.ros2.bridge.ROS2Context"),
            ("SubscribeTwist", "isaacsim.ros2.bridge.ROS2SubscribeTwist"),
            ("BreakLinVel", "omni.graph.nodes.BreakVector3"),
            ("BreakAngVel", "omni.graph.nodes.BreakVector3"),
            ("DiffController", "isaacsim.robot.wheeled_robots.DifferentialController"),
            ("ArtController", "isaacsim.core.nodes.IsaacArticulationController"),
        ],
        k.SET_VALUES: [
            ("SubscribeTwist.inputs:topicName", "cmd_vel"),
            ("DiffController.inputs:wheelRadius", 0.1),
            ("DiffController.inputs:wheelDistance", 0.45),
            ("DiffController.inputs:maxLinearSpeed", 1.3),
            ("DiffController.inputs:maxAngularSpeed", 1.0),
            ("ArtController.inputs:targetPrim", [Sdf.Path(ROBOT)]),
            ("ArtController.inputs:jointNames", ["front_left_wheel_joint", "front_right_wheel_joint"]),
        ],
        k.CONNECT: [
            ("OnPlaybackTick.outputs:tick", "SubscribeTwist.inputs:execIn"),
            ("OnPlaybackTick.outputs:deltaSeconds", "DiffController.inputs:dt"),
            ("SubscribeTwist.outputs:execOut", "DiffController.inputs:execIn"),
            ("SubscribeTwist.outputs:linearVelocity", "BreakLinVel.inputs:tuple"),
            ("BreakLinVel.outputs:x", "DiffController.inputs:linearVelocity"),
            ("SubscribeTwist.outputs:angularVelocity", "BreakAngVel.inputs:tuple"),
            ("BreakAngVel.outputs:z", "DiffController.inputs:angularVelocity"),
            ("DiffController.outputs:velocityCommand", "ArtController.inputs:velocityCommand"),
            ("OnPlaybackTick.outputs:tick", "ArtController.inputs:execIn"),
            ("Context.outputs:context", "SubscribeTwist.inputs:context"),
        ],
    },
)
