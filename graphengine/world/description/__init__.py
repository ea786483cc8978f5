"""Robot descriptions as their authors keep them: xacro, ROS packages, meshes of many formats.

- `source`: from a robot file to its description. `packages` finds files, `xacro` expands, `reader` makes links and joints of XML.
- `for_mujoco`: the description as MuJoCo takes it, with masses by `inertia` and meshes by `meshes` and `conversion`.
- `importing`: a description without a robot file gets one, whose text is made by `robot_file`.
- `confinement`: the processes that a stranger's files are read in, which the kernel holds by `landlock`. `xacro_process` runs in
  one, with `expressions` in place of Python's `eval` and `dom` to remember where things were written; so does `conversion`.
"""
