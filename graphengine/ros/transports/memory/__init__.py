"""The transport `memory`, whose messages stay in this process."""

from graphengine.ros.transport import JoinOptions, Transport, TransportKind


def _open(options: JoinOptions) -> Transport:
    from graphengine.ros.transports.memory.memory import MemoryTransport

    return MemoryTransport(keeps=False, definitions=options.definitions)


TRANSPORT = TransportKind("memory", "no connection: messages stay in the process", _open, reaches_others=False)
