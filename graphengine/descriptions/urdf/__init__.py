"""Links and joints of a description: `urdf_reader` parses them, `for_mujoco` converts them, and `inertia` corrects masses."""
