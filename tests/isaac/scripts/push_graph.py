import omni.graph.core as og

og.Controller.edit(
    "/World/PushGraph",
    {
        og.Controller.Keys.CREATE_NODES: [
            ("a", "omni.graph.nodes.ConstantDouble"),
            ("b", "omni.graph.nodes.ConstantDouble"),
            ("sum", "omni.graph.nodes.Add"),
        ],
        og.Controller.Keys.CONNECT: [("a.inputs:value", "sum.inputs:a"), ("b.inputs:value", "sum.inputs:b")],
        og.Controller.Keys.SET_VALUES: [("a.inputs:value", 1), ("b.inputs:value", 2.5)],
    },
)
