"""Imports a robot description as a robot file.

- `draft`: what the file will hold, and remarks on what was carried over, guessed and lost.
- One module for each part of the file fills the draft from the description; `drivetrain` decides the drives and the base's graph.
- `left_behind` lists the elements of the description that no part has used.
- `bundle` moves meshes beside the description.
- `writer` renders the draft as YAML. `import_robot` does all of it and compiles the robot once before anything is written.
"""
