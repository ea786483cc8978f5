import omni.graph.core as og

graph, *_ = og.Controller.edit(
    {"graph_path": "/World/look", "evaluator_name": "execution"},
    {
        "create_nodes": [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            *[(f"Pub{i}", "isaacsim.ros2.bridge.ROS2PublishClock") for i in range(3)],
        ],
        "connect": [("Tick.outputs:tick", f"Pub{i}.inputs:execIn") for i in range(3)],
    },
)
for node in graph.get_nodes():
    if node.get_type_name().endswith("ROS2PublishClock"):
        name = node.get_prim_path().split("/")[-1]
        node.get_attribute("inputs:topicName").set(f"clock/{name.lower()}")
