"""The services of ROS 2's `simulation_interfaces` (github.com/ros-simulation/simulation_interfaces), 1.5.1 as in Jazzy.

Each request is answered by the session's thread between two ticks, also while there are none. Rooms here: `results` says what a
refusal is called, `states`, `entities` and `spawning` answer, `action` steps, `server` offers all of it on a transport.
"""
