"""Checks of a simulated run: expectations over time with verdicts and margins."""
