import omni
import omni.graph.core as og
import omni.replicator.core as rep
from pxr import Gf

_, sensor = omni.kit.commands.execute(
    "IsaacSensorCreateRtxLidar",
    path="/lidar",
    parent="/World/robot/base",
    config="Example_Rotary",
    translation=(0, 0, 1.0),
    orientation=Gf.Quatd(1.0, 0.0, 0.0, 0.0),
)
texture = rep.create.render_product(sensor.GetPath(), [1, 1], name="Isaac")
og.Controller.edit(
    {"graph_path": "/World/robot/scan", "evaluator_name": "execution"},
    {
        og.Controller.Keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Product", "isaacsim.core.nodes.IsaacCreateRenderProduct"),
            ("Lidar", "isaacsim.ros2.bridge.ROS2RtxLidarHelper"),
        ],
        og.Controller.Keys.SET_VALUES: [
            ("Product.inputs:cameraPrim", sensor.GetPath()),
            ("Lidar.inputs:renderProductPath", texture.path),
            ("Lidar.inputs:type", "point_cloud"),
        ],
        og.Controller.Keys.CONNECT: [
            ("Tick.outputs:tick", "Product.inputs:execIn"),
            ("Product.outputs:execOut", "Lidar.inputs:execIn"),
        ],
    },
)
