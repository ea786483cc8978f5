"""The services of ROS 2's `simulation_interfaces` (github.com/ros-simulation/simulation_interfaces), version 1.5.1 as in Jazzy.

The session's thread answers each request between two ticks, also while it is paused. Modules: `results` maps errors to result
codes; `states`, `entities` and `spawning` implement the services, `action` the action; `server` offers them on a transport.
"""
