import omni.graph.core as og
from omni.graph.core import GraphController
from omni.isaac.core_nodes.scripts.utils import set_target_prims

PLACE = "/ActionGraph/"
og.Controller.edit({"graph_path": "/ActionGraph", "evaluator_name": "execution"})
GraphController.create_node(PLACE + "OnTick", "omni.graph.action.OnTick")
GraphController.create_node(PLACE + "Publish", "omni.isaac.ros2_bridge.ROS2PublishJointState")
og.Controller.set(og.ObjectLookup.attribute(PLACE + "Publish" + "/inputs:topicName"), "/joint_command")
set_target_prims(primPath=PLACE + "Publish", targetPrimPaths=["/World/ur5"])
GraphController.connect(PLACE + "OnTick/outputs:tick", PLACE + "Publish/inputs:execIn")
