"""Converts SDF, the format of Gazebo: models to URDF, worlds to MJCF.

- `sdf_files` reads a file and the files that it includes, as scopes of names.
- `sdf_frames` resolves names and poses according to "Pose Frame Semantics" of the SDF specification.
- `sdf_reader` converts a model to URDF with `<gazebo>` elements; it uses `sdf_links`, `sdf_shapes` and `sdf_joints`.
- `sdf_world` converts a world to MJCF.

SDF never means MuJoCo's signed distance fields here.
"""
