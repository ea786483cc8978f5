"""The state of a session that its nodes share through their contexts, such as the world and the network."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from graphengine.devices.backend import World
from graphengine.devices.random_streams import key_of
from graphengine.devices.stage import Stage
from graphengine.format.permissions import Permissions
from graphengine.format.prim_paths import at_or_below
from graphengine.messages.action_client import ActionClient
from graphengine.messages.actions import ActionServer
from graphengine.messages.endpoints import EndpointClaim, Network, ServiceServer
from graphengine.node.context.render_product import RenderProduct
from graphengine.node.dropped_values import DroppedValues
from graphengine.node.keys import Keyboard
from graphengine.node.mailbox import EventQueue


@dataclass(slots=True)
class Services:
    """The state of one session that its nodes share through their contexts, such as the world and the network."""

    world: World
    network: Network
    seed: int = 0
    domain_id: int = 0
    """ID of the session's ROS 2 domain, to which the domain handle 0 refers."""
    domain_from_environment: int | None = None
    """Value of the environment variable ROS_DOMAIN_ID, or None if it is not set."""
    log: Callable[[str, str, str], None] = lambda severity, node, message: None
    claims: list[EndpointClaim] = field(default_factory=list)
    servers: dict[int, list[ServiceServer]] = field(default_factory=dict)
    """Service servers of each handle: usually one. During a reload there can be two; the last belongs to the new node."""
    handles: dict[tuple[str, int], int] = field(default_factory=dict)
    """Handles of service servers, by prim path of the node and index of the server. A new setup of the node keeps its handles."""
    actions: list[ActionServer | ActionClient] = field(default_factory=list)
    """Action servers and action clients of all nodes."""
    queues: dict[str, EventQueue] = field(default_factory=dict)
    permissions: Permissions = field(default_factory=Permissions)
    keys: Keyboard = field(default_factory=Keyboard)
    generators: dict[str, np.random.Generator] = field(default_factory=dict)
    """Random generators of the nodes, by prim path of the node."""
    render_products: dict[str, RenderProduct] = field(default_factory=dict)
    dropped: DroppedValues | None = field(default_factory=DroppedValues)
    """Count of dropped bad values for each node; None if a bad value ends the run instead."""
    disturbed: bool = False
    """Whether a command has moved or pushed a body since the world was last in its initial state."""
    started: bool = False
    """Whether the session has started. Values of graphs that are added later count as set while the session runs."""

    @property
    def stage(self) -> Stage:
        """The prim tree of the world."""
        return self.world.stage

    def domain(self, handle: int) -> int:
        """Return the ROS 2 domain ID for a domain handle; 0 is the handle of the session's domain."""
        return handle - 1 if handle else self.domain_id

    def save(self) -> Any:
        """Return a copy of the shared state for a checkpoint, without the state of the world and the network."""
        return (
            self.keys.save(),
            self.dropped.save() if self.dropped is not None else None,
            {name: queue.save() for name, queue in self.queues.items()},
            {path: generator.bit_generator.state for path, generator in self.generators.items()},
            {path: (product, product.save()) for path, product in self.render_products.items()},
            dict(self.handles),
            [(action, action.save()) for action in self.actions],
            self.seed,
        )

    def restore(self, saved: Any) -> None:
        """Restore a state that `save` returned; queues, generators and render products that were created later are discarded."""
        keys, dropped, queues, generators, products, handles, actions, self.seed = saved
        self.keys.restore(keys)
        if self.dropped is not None:
            self.dropped.restore(dropped)
        for name in [name for name in self.queues if name not in queues]:
            del self.queues[name]
        for name, state in queues.items():
            self.queues.setdefault(name, EventQueue(name)).restore(state)
        for path in [path for path in self.generators if path not in generators]:
            del self.generators[path]
        for path, state in generators.items():
            self.reseed(path)
            self.generators[path].bit_generator.state = state
        present = self.render_products
        self.render_products = {path: present.get(path, product) for path, (product, _) in products.items()}
        for path, (product, state) in products.items():
            if self.render_products[path] is product:  # a different product belongs to another world
                product.restore(state)
        self.handles = dict(handles)
        for action, state in actions:
            if action in self.actions:
                action.restore(state)

    def forget_calls(self) -> None:
        """End all active action goals and discard all unanswered service calls; used when the graphs restart."""
        for action in self.actions:
            action.restart()
        if self.actions:
            self.network.flush()
        self.network.forget_calls()

    def warn(self, node: str, text: str) -> None:
        """Log a warning to the session's log and to /rosout."""
        self.log("warning", node, text)
        self.network.log("warning", f"{node}: {text}" if node else text)

    def reseed(self, path: str) -> None:
        """Reset the random generator of a node to its initial state, which depends on the session's seed and the prim path."""
        generator = self.generators.setdefault(path, np.random.Generator(np.random.Philox()))
        generator.bit_generator.state = np.random.Philox(key=key_of(self.seed, path)).state

    def forget(self, prim: str) -> None:
        """Remove the render products of all sensors at or below a prim; used when the prim is removed."""
        for path in [path for path, product in self.render_products.items() if at_or_below(product.prim, prim)]:
            del self.render_products[path]
