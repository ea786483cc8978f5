"""The node library: each module holds a family of nodes, each class one node type."""
