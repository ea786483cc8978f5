import omni.graph.core as og

keys = og.Controller.Keys
graph, nodes, _, _ = og.Controller.edit(
    {
        "graph_path": "/World/fast",
        "evaluator_name": "execution",
        "pipeline_stage": og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND,
    },
    {
        keys.CREATE_NODES: [
            ("OnPhysicsStep", "isaacsim.core.nodes.OnPhysicsStep"),
            ("Clock", "isaacsim.ros2.bridge.ROS2PublishClock"),
        ],
        keys.CONNECT: [
            ("OnPhysicsStep.outputs:step", "Clock.inputs:execIn"),
        ],
    },
)
