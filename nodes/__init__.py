"""The node library: one family a file, one class a node type."""
