"""Importing the graphs of USD stages.

`stage_reader` asks the confined `stage_process`, which opens the stage with USD's library; `graphs` makes graphs of its prims.
"""
