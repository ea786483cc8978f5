"""Links and joints: `urdf_reader` parses them, `mujoco_writer` writes them onto an MjSpec, and `inertia` corrects masses."""
