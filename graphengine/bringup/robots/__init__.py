"""Imports a robot description as a robot file.

- Each module adds entries to a `Draft`; `drivetrain` chooses the drives of the joints and the graph of the base.
- `base_names` and `gazebo_profiles` are tables of the names that ros2_control and Gazebo use.
- `left_behind` lists the elements of the description that no module has used.
- `bundle` chooses the files to copy beside the description, such as meshes.
- `import_robot` runs all steps, writes the text of the robot file, and compiles the robot.
"""
