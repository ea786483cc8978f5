"""Isaac Sim's own graphs: scripts and USD stages in, scripts out.

- `recorded`: a graph as an importer found it. `graph_file` makes a YAML file of it and tells what could not be carried over.
- `scripts` imports a Python script: `plain` evaluates one of literals, `script_process` runs any other one, confined, and
  `answers` carries over what it built. Both meet the `modules` of Omniverse: `og` and `usd` tell a `recorder` what a script does
  to graphs, `waiting` is an asyncio without waiting, a `stand_in` takes the place of everything else.
- `stage` imports a USD stage: `stage_process` reads it with USD's own library, confined, and tells of its prims, of which
  `stage_graphs` makes graphs.
- `export` writes the script that builds a graph in Isaac Sim.
"""
