import omni.graph.core as og

graph = og.Controller.create_graph({"graph_path": "/World/pieces", "evaluator_name": "execution"})
tick = og.Controller.create_node("/World/pieces/Tick", "omni.graph.action.OnPlaybackTick")
branch = og.Controller.create_node(("Branch", graph), "omni.graph.action.Branch")
counter = graph.create_node("/World/pieces/Counter", "omni.graph.action.Counter", True)
og.Controller.connect("/World/pieces/Tick.outputs:tick", "/World/pieces/Branch.inputs:execIn")
og.Controller.connect(("outputs:execTrue", branch), ("inputs:execIn", counter))
og.Controller.connect(branch.get_attribute("outputs:execFalse"), counter.get_attribute("inputs:reset"))
og.Controller.set("/World/pieces/Branch.inputs:condition", True)
found = og.get_graph_by_path("/World/pieces")
assert found.is_valid() and og.get_graph_by_path("/World/none") is None
assert [node.get_type_name().rpartition(".")[2] for node in found.get_nodes()] == ["OnPlaybackTick", "Branch", "Counter"]
assert [a.get_path() for a in counter.get_attribute("inputs:execIn").get_upstream_connections()]
