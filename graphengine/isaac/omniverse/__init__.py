"""Stand-ins for the modules of Omniverse that scripts import.

`og` and `usd` tell a `recorder` what a script does to graphs, `waiting` is an asyncio without waiting, a `stand_in` takes the
place of everything else.
"""
