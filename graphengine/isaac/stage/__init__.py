"""Imports the graphs of USD stages.

`stage_reader` starts the confined `stage_process`, which opens the stage with USD's library; `graphs` converts prims to graphs.
"""
