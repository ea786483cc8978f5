"""Stubs for the modules of Omniverse that scripts import.

`og` and `usd` record a script's edits of graphs in a `graph_recorder`; `script_notes` hold what it does besides.
`asyncio_stub` runs coroutines without waiting, and `stubs` replace everything else.
"""
