"""Robot files: `robot_file` merges one with those that it extends; `draft` holds a new one, which `writer` renders as YAML."""
