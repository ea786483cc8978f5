"""Reads descriptions of robots and worlds: robot files, URDF, xacro, SDF, MJCF and USD, and the files to which they refer.

Each entry of this list imports only from the entries above it:

- `engine`: imports MuJoCo with the settings that the whole package uses. `geoms`: reads shapes from a compiled model.
- `files`: reads untrusted files within limits.
- `actuators`: drives of joints, and the MuJoCo model that a description may be.
- `robot_description`: links, joints and `shapes` as plain data, which all descriptions become; `link_tree` connects and
  checks them, `inertia` corrects masses, and `mujoco_writer` writes them onto an MjSpec.
- `urdf`: reads URDF, and writes it for robot_state_publisher.
- `xacro`, `sdf`, `mjcf` and `usd` read the other formats (`usd_model` is the plain data of a stage); `robot_files` reads robot
  files and writes new ones.
- `description_reader`: reads a description, with the robot file that names it or with a generated one.
"""
