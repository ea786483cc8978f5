"""Robot descriptions as links and joints: robot files, URDF, xacro and MuJoCo models.

- `robot_file` merges a robot file with those that it extends.
- `description_reader` reads a description, with a robot file or without one. `xacro` expands it, `graphengine.physics.sdf`
  converts SDF to URDF, and `urdf_reader` parses the XML into links with their shapes and joints (`urdf`,
  `shapes`).
- `mujoco_writer` writes a description onto an MjSpec; `inertia` corrects its masses. `mjcf` reads MuJoCo's own models.
- `xacro_process` runs xacro confined; `xacro_expressions` replaces Python's `eval`, and `dom` keeps source locations.
"""
