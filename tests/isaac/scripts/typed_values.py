import omni.graph.core as og
from pxr import Gf

keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/typed", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("Tick", "omni.graph.action.OnPlaybackTick"),
            ("Add", "omni.graph.nodes.Add"),
            ("Size", "omni.graph.nodes.Magnitude"),
            ("Compare", "omni.graph.nodes.Compare"),
            ("Branch", "omni.graph.action.Branch"),
        ],
        keys.SET_VALUES: [
            ("Add.inputs:a", Gf.Vec3d(1.0, 2.0, 3.0) * 2.0, "double[3]"),
            ("Add.inputs:b", Gf.Vec3d(0, 0, 1), "double[3]"),
            ("Compare.inputs:operation", ">"),
            ("Compare.inputs:b", 3, "double"),
        ],
        keys.CONNECT: [
            ("Tick.outputs:tick", "Branch.inputs:execIn"),
            ("Add.outputs:sum", "Size.inputs:input"),
            ("Size.outputs:magnitude", "Compare.inputs:a"),
            ("Compare.outputs:result", "Branch.inputs:condition"),
        ],
    },
)
