"""Robots as their authors describe them: robot files, URDF, xacro and MuJoCo's models, made into links and joints.

- `robot_file` and what it extends; `draft` writes the first one for a description, `bare` does without.
- `source`: from a robot file to its description. `xacro` expands, `reader` makes `urdf`, links and joints, of XML.
- `for_mujoco`: the description as MuJoCo takes it, with masses by `inertia`. `mjcf`: one of MuJoCo's own.
- `xacro_process` runs confined, with `expressions` in place of Python's `eval` and `dom` to remember where things were written.
"""
