"""Expands xacro in a confined process, with restricted expressions in place of Python's `eval`, and with source locations."""
