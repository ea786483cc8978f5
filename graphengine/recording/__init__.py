"""Recordings: all inputs and outputs of a run as an MCAP file, and replays that are compared byte by byte.

A recording is what `ros2 bag play`, Foxglove and every reader of MCAP's profile `ros2` take for a bag, and more:

- **Channels**, one for each topic and type, with what nodes published and what came to them from outside; each message once, as
  in a bag. Schemas are definitions as `ros2msg` text.
- **Services** as ROS 2's service introspection has them: events of the type `…_Event` on `<service>/_service_event`.
- **`/_graphengine/delivered/…`**: what came to nodes and lies on the topic's own channel already, as the run published it itself
  or another node saw it before (`seen_messages`).
- **`/_graphengine/session`**, a channel of std_msgs/msg/String: what came from outside in a tick, as JSON. `delivered` has lists
  of nodes: so many of the tick's messages, its first ones, came to them. Then `commands`, and `wall_time` in ticks in which a
  node read the clock.
- **Times** are of the simulation, so that the same run makes the same file. `log_time` counts from the recording's first tick
  and never goes back; `publish_time` counts from the last play. A delivery bears the time of the tick that saw it.
- **Order** in the file is the order in which things happened: what came from outside in a tick, what came to nodes, then what
  they published. A chunk ends where a tick ends, so that a file which was cut off is whole up to its last chunk.
- **Metadata** `graphengine` (`manifest.Manifest`), `graphengine:files` (the SHA-256 of each attachment) and `graphengine:end`.
- **Attachments**: every file that the run read, by a name that says nothing of the machine (`sources`).
"""
