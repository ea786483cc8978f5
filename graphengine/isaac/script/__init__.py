"""Imports Isaac Sim scripts that build graphs.

`script_reader` starts the confined `script_process`, which evaluates literals (`static_evaluation`) or runs the script
(`script_run`).
"""
