import omni.usd
from pxr import Sdf

stage = omni.usd.get_context().get_stage()
graph = stage.DefinePrim("/World/raw", "OmniGraph")
graph.CreateAttribute("evaluator:type", Sdf.ValueTypeNames.Token).Set("execution")
tick = stage.DefinePrim("/World/raw/Tick", "OmniGraphNode")
tick.CreateAttribute("node:type", Sdf.ValueTypeNames.Token).Set("omni.graph.action.OnPlaybackTick")
tick.CreateAttribute("node:typeVersion", Sdf.ValueTypeNames.Int).Set(2)
clock = stage.DefinePrim("/World/raw/Clock", "OmniGraphNode")
clock.CreateAttribute("node:type", Sdf.ValueTypeNames.Token).Set("isaacsim.ros2.bridge.ROS2PublishClock")
clock.CreateAttribute("inputs:execIn", Sdf.ValueTypeNames.UInt).AddConnection(tick.GetPath().AppendProperty("outputs:tick"))
clock.CreateAttribute("inputs:topicName", Sdf.ValueTypeNames.String).Set("raw_clock")
