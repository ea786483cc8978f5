"""Isaac Sim's own graphs: scripts and USD stages in, scripts out.

- `recorded`: a graph as an importer found it. `graph_file` makes a YAML file of it and tells what could not be carried over.
- `script` imports a Python script; what it imports are the stand-ins of `omniverse`.
- `stage` imports a USD stage.
- `export` writes the script that builds a graph in Isaac Sim.
"""
