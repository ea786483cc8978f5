"""The Context of nodes. It gives a node handles to the world and endpoints of the network, and checks names against the stage.

`graphrun check` and running sessions use the same classes; `graphrun check` passes stubs of the world and the network to them.
"""
