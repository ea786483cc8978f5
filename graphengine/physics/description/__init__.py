"""Robot descriptions as links and joints: robot files, URDF, xacro and MuJoCo models.

- `robot_file` merges a robot file with those that it extends.
- `description_reader` reads a description, with a robot file or without one. `xacro` expands it, `sdf` beside this folder
  converts SDF to URDF, `urdf_reader` parses the XML to links and joints (`urdf`).
- `for_mujoco` converts a description for MuJoCo, with masses by `inertia`. `mjcf` reads MuJoCo's own models.
- `xacro_process` runs confined, with `xacro_expressions` instead of Python's `eval` and a `dom` that keeps source locations.
"""
