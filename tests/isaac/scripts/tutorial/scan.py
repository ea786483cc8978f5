import omni.graph.core as og
import omni.usd
from pxr import Sdf

SENSOR = "/dd100/Geometry/base_link/chassis_link/sim_lidar"
PATH = f"{SENSOR}/scan"
stage = omni.usd.get_context().get_stage()
if stage.GetPrimAtPath(PATH):
    stage.RemovePrim(PATH)
k = og.Controller.Keys
og.Controller.edit(
    {"graph_path": PATH, "evaluator_name": "execution"},
    {
        k.CREATE_NODES: [
            ("OnPlaybackTick", "omni.graph.action.OnPlaybackTick"),
            ("RunOneFrame", "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame"),
            ("CreateRenderProduct", "isaacsim.core.nodes.IsaacCreateRenderProduct"),
            ("Context", "isaacsim.ros2.bridge.ROS2Context"),
            ("LidarHelper", "isaacsim.ros2.bridge.ROS2RtxLidarHelper"),
        ],
        k.SET_VALUES: [
            ("CreateRenderProduct.inputs:cameraPrim", [Sdf.Path(f"{SENSOR}/Lidar")]),
            ("LidarHelper.inputs:frameId", "sim_lidar"),
            ("LidarHelper.inputs:topicName", "scan"),
            ("LidarHelper.inputs:type", "laser_scan"),
        ],
        k.CONNECT: [
            ("OnPlaybackTick.outputs:tick", "RunOneFrame.inputs:execIn"),
            ("RunOneFrame.outputs:step", "CreateRenderProduct.inputs:execIn"),
            ("CreateRenderProduct.outputs:execOut", "LidarHelper.inputs:execIn"),
            ("CreateRenderProduct.outputs:renderProductPath", "LidarHelper.inputs:renderProductPath"),
            ("Context.outputs:context", "LidarHelper.inputs:context"),
        ],
    },
)
