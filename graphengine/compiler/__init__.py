"""Compiles graph files to Python functions: `subgraph_expansion`, `resolve`, `planning` and `codegen`, in this order."""
