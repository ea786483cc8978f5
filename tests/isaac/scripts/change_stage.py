import omni.graph.core as og

graph, *_ = og.Controller.edit(
    {"graph_path": "/World/late", "evaluator_name": "execution"},
    {"create_nodes": [("OnPhysicsStep", "isaacsim.core.nodes.OnPhysicsStep")]},
)
other, *_ = og.Controller.edit(
    {"graph_path": "/World/asked", "evaluator_name": "execution"},
    {"create_nodes": [("Tick", "omni.graph.action.OnTick")]},
)
for one in og.get_all_graphs():
    one.change_pipeline_stage(og.GraphPipelineStage.GRAPH_PIPELINE_STAGE_ONDEMAND)
