"""The node library: one family per file, one class per node type."""
