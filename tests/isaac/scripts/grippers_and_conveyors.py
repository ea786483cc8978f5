import omni.graph.core as og
keys = og.Controller.Keys
og.Controller.edit(
    {"graph_path": "/World/ConveyorBeltGraph", "evaluator_name": "execution"},
    {
        keys.CREATE_VARIABLES: [("Velocity", "float")],
        keys.CREATE_NODES: [
            ("OnTick", "omni.graph.action.OnPlaybackTick"),
            ("ConveyorNode", "isaacsim.asset.gen.conveyor.IsaacConveyor"),
            ("read_speed", "omni.graph.core.ReadVariable"),
            ("Cup", "omni.isaac.surface_gripper.SurfaceGripper"),
            ("Beam", "omni.isaac.range_sensor.IsaacReadLightBeam"),
            ("Effort", "omni.isaac.sensor.IsaacReadEffortSensor"),
            ("Ray", "isaacsim.sensors.physics.IsaacReadRaycastSensor"),
            ("Hand", "omni.isaac.manipulators.IsaacGripperController"),
        ],
        keys.SET_VALUES: [
            ("read_speed.inputs:graph", "/World/ConveyorBeltGraph"),
            ("read_speed.inputs:variableName", "Velocity"),
            ("ConveyorNode.inputs:conveyorPrim", "/World/belt"),
            ("Cup.inputs:SurfaceGripper", "/robot/hand/cup"),
            ("Beam.inputs:lightbeamPrim", "/robot/hand/beam"),
            ("Ray.inputs:raycastSensorPrim", "/robot/hand/rays"),
            ("Effort.inputs:prim", "/robot/Physics/lift"),
            ("Hand.inputs:articulationRootPrim", "/robot"),
            ("Hand.inputs:jointNames", ["lift"]),
            ("Hand.inputs:gripperSpeed", [0.01]),
        ],
        keys.CONNECT: [
            ("OnTick.outputs:tick", "ConveyorNode.inputs:onStep"),
            ("OnTick.outputs:deltaSeconds", "ConveyorNode.inputs:delta"),
            ("read_speed.outputs:value", "ConveyorNode.inputs:velocity"),
            ("OnTick.outputs:tick", "Cup.inputs:Close"),
            ("OnTick.outputs:tick", "Beam.inputs:execIn"),
            ("OnTick.outputs:tick", "Effort.inputs:execIn"),
            ("OnTick.outputs:tick", "Ray.inputs:execIn"),
            ("OnTick.outputs:tick", "Hand.inputs:execIn"),
        ],
    },
)
