"""Drawings of graphs as SVG and HTML.

- `view_model`: the nodes, wires and subgraphs of a drawing; `finding_assignment` assigns findings to nodes.
- `node_box` lays out a node. `nested_layout` lays out a graph with its subgraphs by `layered_layout`, `manual_layout` or
  `column_layout`; `routing` routes links around boxes.
- `svg` and `page` write the files.
"""
