"""Importing Isaac Sim scripts that build graphs.

`script_reader` asks the confined `script_process`, which evaluates literals (`static_evaluation`) or runs the script
(`script_run`).
"""
