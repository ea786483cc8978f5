"""Stubs for the Omniverse modules that scripts import.

`og` and `usd` record a script's edits of graphs in a `graph_recorder`; `script_notes` records its other actions. `asyncio_stub`
runs coroutines without waiting, and `stubs` replaces everything else.
"""
