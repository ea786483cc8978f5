"""Drawings of graphs.

- `scheme`: what is on them; `painting`: which findings belong where.
- `arrange`: where everything stands; `figure` lays out the boxes, `layered` and `placed` put them, `routing` leads wires around.
- `svg` and `page`: how they are written.
"""
