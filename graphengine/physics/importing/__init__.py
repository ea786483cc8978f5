"""Imports a robot description as a robot file.

- `draft` is the data model of the robot file, with remarks on values that were carried over, guessed and lost.
- One module for each part of the file fills the draft from the description; `drivetrain` chooses the drives and the base's graph.
- `left_behind` lists the elements of the description that no module has used.
- `bundle` chooses the files to copy beside the description, such as meshes.
- `writer` renders the draft as YAML.
- `import_robot` runs all steps, and compiles the robot once before any file is written.
"""
