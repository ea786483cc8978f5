import numpy as np
import omni.graph.core as og

radii = np.full(4, 0.05)
angles = np.array([np.pi / 4, -np.pi / 4, -np.pi / 4, np.pi / 4])
positions = np.array([[0.2, 0.1, 0.0], [0.2, -0.1, 0.0], [-0.2, 0.1, 0.0], [-0.2, -0.1, 0.0]], dtype=np.float64)
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/holonomic", "evaluator_name": "execution"},
    {
        keys.CREATE_NODES: [
            ("tick", "omni.graph.action.OnPlaybackTick"),
            ("drive", "isaacsim.robot.wheeled_robots.HolonomicController"),
        ],
        keys.CONNECT: [("tick.outputs:tick", "drive.inputs:execIn")],
        keys.SET_VALUES: [
            ("drive.inputs:wheelRadius", radii),
            ("drive.inputs:wheelPositions", positions),
            ("drive.inputs:mecanumAngles", angles),
            ("drive.inputs:wheelOrientations", np.tile([1.0, 0.0, 0.0, 0.0], (4, 1))),
            ("drive.inputs:maxLinearSpeed", np.float32(0.5)),
            ("drive.inputs:wheelAxis", np.array([0.0, 1.0, 0.0])),
        ],
    },
)
