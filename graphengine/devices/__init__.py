"""Stand-ins for world and network, for checks and for tests of nodes."""
