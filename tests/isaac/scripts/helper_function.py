import omni.graph.core as og
from pxr import Sdf


def create_drive_graph(robot_path, wheel_radius=0.1, *, wheel_distance):
    """Build the drive graph of a robot."""
    keys = og.Controller.Keys
    graph, _, _, _ = og.Controller.edit(
        {"graph_path": robot_path + "/drive", "evaluator_name": "execution"},
        {
            keys.CREATE_NODES: [
                ("tick", "omni.graph.action.OnPlaybackTick"),
                ("twist", "isaacsim.ros2.bridge.ROS2SubscribeTwist"),
                ("scale", "my_company.nodes.ScaleToStageUnit"),
                ("linear", "omni.graph.nodes.BreakVector3"),
                ("angular", "omni.graph.nodes.BreakVector3"),
                ("diff", "isaacsim.robot.wheeled_robots.DifferentialController"),
                ("move", "isaacsim.core.nodes.IsaacArticulationController"),
            ],
            keys.CONNECT: [
                ("tick.outputs:tick", "twist.inputs:execIn"),
                ("twist.outputs:execOut", "diff.inputs:execIn"),
                ("twist.outputs:linearVelocity", "scale.inputs:value"),
                ("scale.outputs:result", "linear.inputs:tuple"),
                ("linear.outputs:x", "diff.inputs:linearVelocity"),
                ("twist.outputs:angularVelocity", "angular.inputs:tuple"),
                ("angular.outputs:z", "diff.inputs:angularVelocity"),
                ("tick.outputs:tick", "move.inputs:execIn"),
                ("diff.outputs:velocityCommand", "move.inputs:velocityCommand"),
            ],
            keys.SET_VALUES: [
                ("diff.inputs:wheelRadius", wheel_radius),
                ("diff.inputs:wheelDistance", wheel_distance),
                ("move.inputs:targetPrim", Sdf.Path(robot_path)),
                ("move.inputs:jointNames", ["left_wheel_joint", "right_wheel_joint"]),
            ],
        },
    )
    return graph


if __name__ == "__main__":
    graph = create_drive_graph("/World/carter", wheel_distance=0.54)
    print("made", graph.get_path_to_graph())
