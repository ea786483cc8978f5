import omni.graph.core as og
import usdrt.Sdf

CAMERA = "/World/robot/camera"
HELPERS = {"Rgb": ("rgb", "image_raw"), "Depth": ("depth", "depth/image_raw"), "Points": ("depth_pcl", "points")}
keys = og.Controller.Keys
nodes = [
    ("OnTick", "omni.graph.action.OnPlaybackTick"),
    ("Once", "isaacsim.core.nodes.OgnIsaacRunOneSimulationFrame"),
    ("Product", "isaacsim.core.nodes.IsaacCreateRenderProduct"),
    ("Info", "isaacsim.ros2.bridge.ROS2CameraInfoHelper"),
]
wires = [
    ("OnTick.outputs:tick", "Once.inputs:execIn"),
    ("Once.outputs:step", "Product.inputs:execIn"),
    ("Product.outputs:execOut", "Info.inputs:execIn"),
    ("Product.outputs:renderProductPath", "Info.inputs:renderProductPath"),
]
values = [
    ("Product.inputs:cameraPrim", [usdrt.Sdf.Path(CAMERA)]),
    ("Product.inputs:width", 640.0),
    ("Product.inputs:height", int(480)),
    ("Info.inputs:topicName", "camera_info"),
    ("Info.inputs:frameId", "camera"),
]
for name, (kind, topic) in HELPERS.items():
    nodes.append((name, "isaacsim.ros2.bridge.ROS2CameraHelper"))
    wires.append(("Product.outputs:execOut", name + ".inputs:execIn"))
    wires.append(("Product.outputs:renderProductPath", name + ".inputs:renderProductPath"))
    values += [(f"{name}.inputs:{key}", value) for key, value in (("type", kind), ("topicName", topic), ("frameId", "camera"))]

og.Controller.edit(
    {"graph_path": "/World/robot/camera_graph", "evaluator_name": "execution"},
    {keys.CREATE_NODES: nodes, keys.CONNECT: wires, keys.SET_VALUES: values},
)
