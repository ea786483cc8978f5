"""Stages that hold graphs: `reading` them with USD's own library in a confined `process`; `graphs` are made of its prims."""
