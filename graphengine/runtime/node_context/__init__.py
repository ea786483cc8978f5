"""The Context that nodes get: names and checks from the stage, handles from a world and a network.

The same classes serve a dry setup, over stand-ins, and a running session; so what `check` sees is what `run` does.
"""
