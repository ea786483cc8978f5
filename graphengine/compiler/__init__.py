"""From a file's nodes and wires to Python that runs: `template`, `resolve`, `planning`, `codegen`, `executor`, in this order."""
