TICK = "omni.graph.action.OnPlaybackTick"
