"""The class Context, from which a node gets its handles to the world and its endpoints on the network.

It checks names against the stage. `graphrun check` uses the same classes as a running session, with stubs of the world and
the network.
"""
