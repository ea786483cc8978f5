"""Reads descriptions of robots and worlds: robot files, URDF, xacro, SDF and MJCF, and the files to which they refer.

Each entry of this list imports only from the entries above it:

- `engine`: imports MuJoCo with the settings that the whole package uses. `geoms`: reads shapes from a compiled model.
- `files`: reads untrusted files within limits.
- `actuators`: drives of joints, and the MuJoCo model that a description may be.
- `urdf`: links and joints, which all descriptions become.
- `xacro`, `sdf` and `mjcf` read the other formats; `robot_files` reads robot files and writes new ones.
- `description_reader`: reads a description, with the robot file that names it or with a generated one.
"""
