"""SDF, the format of Gazebo: models become URDF, and worlds become MJCF.

- `sdf_files` reads a file and what it includes, as scopes of names.
- `sdf_frames` resolves names and poses, as the specification's "Pose Frame Semantics" says.
- `sdf_reader` converts a model to a URDF with elements for Gazebo, by `sdf_links`, `sdf_shapes` and `sdf_joints`.
- `sdf_world` converts a world to MJCF.

MuJoCo calls its signed distance fields SDF too; these are not meant here.
"""
