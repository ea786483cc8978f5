"""The Context that nodes get: names and checks from the stage, handles from a world and a network.

The same classes serve `check`, over stand-ins of world and network, and a running session.
"""
