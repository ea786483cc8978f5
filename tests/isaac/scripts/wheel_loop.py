import omni.graph.core as og

WHEELS = ["front_left", "front_right", "rear_left", "rear_right"]
keys = og.Controller.Keys
nodes = [("OnTick", "omni.graph.action.OnPlaybackTick"), ("Names", "omni.graph.nodes.ConstructArray")]
values = [("Names.inputs:arrayType", "token[]"), ("Names.inputs:arraySize", len(WHEELS))]
attributes, wires = [], []
for index, wheel in enumerate(WHEELS):
    nodes.append((f"Name_{wheel}", "omni.graph.nodes.ConstantToken"))
    values.append((f"Name_{wheel}.inputs:value", f"{wheel}_joint"))
    if index:
        attributes.append((f"Names.inputs:input{index}", "token"))
    wires.append((f"Name_{wheel}.inputs:value", f"Names.inputs:input{index}"))
nodes.append(("Controller", "isaacsim.core.nodes.IsaacArticulationController"))
values.append(("Controller.inputs:robotPath", "/World/robot"))
wires += [("OnTick.outputs:tick", "Controller.inputs:execIn"), ("Names.outputs:array", "Controller.inputs:jointNames")]

og.Controller.edit(
    {"graph_path": "/World/wheels", "evaluator_name": "execution"},
    {
        keys.CREATE_ATTRIBUTES: attributes,
        keys.SET_VALUES: values,
        keys.CONNECT: wires,
        keys.CREATE_NODES: nodes,
    },
)
