"""Robot descriptions as links and joints: robot files, URDF, xacro and MuJoCo's models.

- `robot_file` merges a robot file with those that it extends.
- `description_reader` reads a description, with a robot file or without one. `xacro` expands it, `urdf_reader` parses the XML
  to links and joints (`urdf`).
- `for_mujoco`: the description as MuJoCo takes it, with masses by `inertia`. `mjcf`: one of MuJoCo's own.
- `xacro_process` runs confined, with `xacro_expressions` in place of Python's `eval` and a `dom` that keeps source locations.
"""
