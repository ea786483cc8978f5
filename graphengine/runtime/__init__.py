"""Sessions: the tick and its pace, graph execution, the contexts of nodes, checks, and the command queue."""
