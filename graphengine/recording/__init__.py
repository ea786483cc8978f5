"""Recordings: everything that a run read, heard and said, as an MCAP file; and the same run once more, compared byte by byte.

A recording is what `ros2 bag play`, Foxglove and every reader of MCAP's profile `ros2` take for a bag, and more:

- **Channels** with the messages that nodes published, one a topic and type, and with those that were delivered to subscriptions,
  one for each topic, type and set of nodes that saw the same message in the same tick. A channel's metadata has `direction`
  (`published`, `delivered`) and, for the latter, `nodes`. Schemas are definitions as `ros2msg` text.
- **Times** are of the simulation, so that the same run makes the same file. `log_time` counts from the recording's first tick
  and never goes back; `publish_time` counts from the last play. A delivery bears the time of the tick that saw it.
- **Order** in the file is the order in which things happened: a tick's inputs, then its messages as they were sent. A chunk ends
  where a tick ends, so that a file which was cut off is whole up to its last chunk.
- **`/graphengine/session`**, a channel of std_msgs/msg/String: what else came from outside in a tick, as JSON. `commands`, and
  `wall_time` in ticks in which a node read the clock.
- **Metadata** `graphengine` (`manifest.Manifest`), `graphengine:files` (the SHA-256 of each attachment) and `graphengine:end`.
- **Attachments**: every file that the run read, by a name that says nothing of the machine (`sources`).
"""
