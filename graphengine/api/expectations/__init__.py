"""Expectations over the time of a run, with verdicts and margins."""
