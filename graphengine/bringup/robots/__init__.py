"""Imports a robot description as a robot file.

- One module for each part of the file fills a `draft` from the description; `drivetrain` chooses the drives and the base's graph.
- `left_behind` lists the elements of the description that no module has used.
- `bundle` chooses the files to copy beside the description, such as meshes.
- `import_robot` runs all steps, renders the draft as YAML, and compiles the robot once before any file is written.
"""
