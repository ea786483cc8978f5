import omni.graph.core as og
from omni.isaac.core_nodes.scripts.utils import set_target_prims

og.Controller.edit(
    {"graph_path": "/ActionGraph", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_NODES: [
            ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
            ("ReadSimTime", "omni.isaac.core_nodes.IsaacReadSimulationTime"),
            ("PublishTF", "omni.isaac.ros2_bridge.ROS2PublishTransformTree"),
            ("Diff", "omni.isaac.wheeled_robots.DifferentialController"),
            ("Articulation", "omni.isaac.core_nodes.IsaacArticulationController"),
        ],
        og.Controller.Keys.SET_VALUES: [
            ("Diff.inputs:wheelRadius", 0.0325),
            ("Diff.inputs:wheelDistance", 0.118),
            ("Articulation.inputs:usePath", False),
            ("ReadSimTime.inputs:swhFrameNumber", 0),
        ],
        og.Controller.Keys.CONNECT: [
            ("OnPlaybackTick.outputs:tick", "PublishTF.inputs:execIn"),
            ("OnPlaybackTick.outputs:tick", "Diff.inputs:execIn"),
            ("OnPlaybackTick.outputs:tick", "Articulation.inputs:execIn"),
            ("Diff.outputs:velocityCommand", "Articulation.inputs:velocityCommand"),
            ("ReadSimTime.outputs:simulationTime", "PublishTF.inputs:timeStamp"),
        ],
    },
)
set_target_prims(
    primPath="/ActionGraph/PublishTF", inputName="inputs:targetPrims", targetPrimPaths=["/World/robot", "/World/box"]
)
set_target_prims(primPath="/ActionGraph/Articulation", targetPrimPaths=["/World/robot"])
