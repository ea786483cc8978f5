"""Recordings: all inputs and outputs of a run as an MCAP file, and replays that are compared byte by byte.

A recording is a bag for `ros2 bag play`, Foxglove and every reader of MCAP's profile `ros2`, with additional data for replays:

- **Channels**, one per topic and type, contain the messages that nodes published or received from outside. As in a bag, each
  message occurs once. Schemas are message definitions as `ros2msg` text.
- **Services** are recorded as by ROS 2's service introspection: events of type `…_Event` on `<service>/_service_event`.
- **`/_graphengine/delivered/…`** contains received messages that the topic's own channel already has, because the run itself
  published the message or another node received it before (`seen_messages`).
- **`/_graphengine/session`**, a channel of std_msgs/msg/String, contains the external inputs of each tick as JSON: `delivered`,
  with one list of receiving nodes for each received message of the tick; `commands`; and `wall_time` if a node read the clock.
- **`/_graph/…`** contains the values of the ports that `--ports` chose, as messages of std_msgs, one for each change. Replays
  ignore these channels. They are not JSON, because rosbag2 plays no bag with two serialization formats.
- **Times** are simulation times, so that equal runs make equal files. `log_time` counts from the recording's first tick and never
  goes back; `publish_time` counts from the last play. A received message has the time of the tick in which nodes received it.
- **Order**: each tick consists of external inputs, then received messages, then published messages. A chunk ends at the end of a
  tick, so that a truncated file is complete up to its last chunk.
- **Metadata**: `graphengine` (`manifest.Manifest`), `graphengine:files` (SHA-256 of each attachment) and `graphengine:end`.
- **Attachments**: all files that the run read, under machine-independent names (`sources`).
"""
