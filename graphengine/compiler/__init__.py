"""Compiles graph files to Python functions, in four steps: `subgraph_expansion`, `resolve`, `planning` and `codegen`."""
