"""Runs and checks compiled graphs: sessions with their ticks and commands, execution of graphs, and setup without physics."""
