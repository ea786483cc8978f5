"""Robot files: `robot_file` merges one with those that it extends; `draft` holds a new one, whose text `writer` makes.

`entries` has the typed entries of a draft. `description_reader` checks the values of a draft without a text.
"""
