"""Expands xacro: `xacro_process` confined, `xacro_expressions` in the place of Python's `eval`, `dom` with source locations."""
