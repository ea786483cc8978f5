"""The Context of nodes: handles to the world and endpoints of the network, with names checked against the stage.

`check` and running sessions use the same classes; `check` has stubs of the world and the network.
"""
