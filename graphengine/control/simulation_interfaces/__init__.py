"""The services of ROS 2's `simulation_interfaces` (github.com/ros-simulation/simulation_interfaces), version 1.5.1 as in Jazzy.

The session's thread executes each request between two ticks, also while the session is paused. `results` maps errors to result
codes; `states`, `entities` and `spawning` handle the service requests; `action` implements the action; `server` creates the
services and the action on a transport.
"""
