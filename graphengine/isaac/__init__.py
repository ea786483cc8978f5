"""Imports graphs from Isaac Sim scripts and USD stages, and exports graphs as Isaac Sim scripts.

- `recorded_graph` defines the graphs that importers return. `graph_file` writes them as YAML and reports losses.
- `script` imports a Python script. `omniverse` contains the stubs of Omniverse's modules that the script uses.
- `stage` imports a USD stage.
- `node_replacements` suggests replacements for unavailable node types and upgrades nodes of older Isaac Sim versions.
- `export` writes a Python script that builds a graph in Isaac Sim.
"""
