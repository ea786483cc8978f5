"""Isaac Sim's graph formats: imports scripts and USD stages, exports scripts.

- `recorded_graph`: a graph as an importer found it. `graph_file` writes it as YAML and reports what could not be converted.
- `script` imports a Python script, for which `omniverse` has stubs of Omniverse's modules.
- `stage` imports a USD stage.
- `node_replacements` replaces node types that are not available and updates old ones.
- `export` writes the script that builds a graph in Isaac Sim.
"""
