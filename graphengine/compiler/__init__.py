"""From a file's nodes and wires to generated Python: `template`, `resolve`, `planning`, `codegen`, in this order."""
