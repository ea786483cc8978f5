"""Sessions: the tick and its pace, the execution of plans, the contexts of nodes, checks, and the queue of commands."""
