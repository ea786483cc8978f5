import omni.graph.core as og

controller = og.Controller()
keys = og.Controller.Keys
graph, nodes, _, name_map = controller.edit(
    {"graph_path": "/World/states", "evaluator_name": "execution"},
    {keys.CREATE_NODES: [("Tick", "omni.graph.action.OnPlaybackTick"), ("Pub", "isaacsim.ros2.bridge.ROS2PublishJointState")]},
)
tick, publish = nodes
controller.connect(tick.get_attribute("outputs:tick"), publish.get_attribute("inputs:execIn"))
controller.edit(graph, {keys.SET_VALUES: [("Pub.inputs:targetPrim", "/World/arm")]})
controller.attribute("inputs:topicName", name_map["Pub"]).set("arm/joint_states")
assert controller.get(controller.attribute("Pub.inputs:topicName", graph_id=graph)) == "arm/joint_states"
