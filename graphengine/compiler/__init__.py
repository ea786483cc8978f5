"""Graph files to generated Python: `subgraph_expansion`, `resolve`, `planning`, `codegen`, in this order."""
