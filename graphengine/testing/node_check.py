"""A check that a node class has everything that users and the engine expect."""

from __future__ import annotations

import inspect
import itertools
import json
import re
import traceback
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from graphengine.compiler.registry import Registry, default_registry
from graphengine.compiler.schema import make_schema
from graphengine.format.errors import GraphError
from graphengine.node.node_class import Node, NodeClassError
from graphengine.node.port import Port
from graphengine.node.types import UnionType
from graphengine.testing.recording_context import RecordingContext


def check_node(cls: type[Node], make: Callable[[], RecordingContext] = RecordingContext, /, **inputs: Any) -> None:
    """Check a node class; raise NodeClassError with a list of everything that is missing or wrong.

    The class needs a docstring with a first line, documented ports, units of physical quantities, a unique name, legal defaults
    and a JSON Schema. The check then computes the node for three ticks and, after a stop, three more: two instances and both
    plays must give the same outputs and messages. The node may raise ValueError or GraphError.

    Args:
        cls: node class.
        make: returns a new context for a node.
        inputs: values of inputs by Python name, including all required ones.

    Raises:
        NodeClassError: something is missing or wrong.
    """
    problems = [*_words(cls), *_shape(cls), *_behaviour(cls, make, inputs)]
    if problems:
        raise NodeClassError("\n  - ".join([f"{cls.__module__}.{cls.__qualname__} is not a sound node:", *problems]))


_PHYSICAL = "acceleration angle delay distance dt duration effort force frequency length mass period position radius "
_PHYSICAL += "rate second speed stamp temperature time timeout torque translation velocity velocitie"


def _words(cls: type[Node]) -> Iterator[str]:
    first = (inspect.getdoc(cls) or "").partition("\n")[0] if cls.__doc__ else ""
    if not first.endswith(".") or re.match(r"(?i)(this|a node|the node|node that|class)\b", first):
        yield f"the first line of its docstring must say what the node does and end with a full stop, it is {first!r}"
    for port in (port for port in cls.fields.values() if port.side != "state" and not port.is_exec):
        told = port.doc or port.unit or port.tokens or port.component or re.search(r"[A-Z_]", port.name)
        if not told and port.name.lower() not in cls.type_name.lower():
            yield f"{port.name}: a name of one word needs a doc"
        words = {word.removesuffix("s") for word in port.field.split("_")}
        real = str(port.type).startswith(("double", "float", "half", "vector"))
        if real and not port.unit and "type" not in words and words.intersection(_PHYSICAL.split()):
            yield f"{port.name}: a physical quantity needs a unit"


def _shape(cls: type[Node]) -> Iterator[str]:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+", cls.type_name):
        yield f"a registered name has several parts, as in my_robots.Gripper; type= is {cls.type_name!r}"
    for name in (cls.type_name, *cls.aliases):
        if (other := default_registry().types.get(name, cls)) not in cls.__mro__:  # one may have grown ports
            yield f"{name!r} is the name of {other.__module__}.{other.__qualname__}"
    named = [f"{port.side}:{port.name}" for port in cls.fields.values()]
    yield from (f"{named.count(name)} ports are called {name}" for name in sorted(set(named)) if named.count(name) > 1)
    for port in cls.fields.values():
        try:
            if port.side != "state" and not port.is_exec and not port.required:
                port.check(port.default)
        except (TypeError, ValueError) as error:
            yield f"{port.name}: its default {port.default!r} is not legal: {error}"
    try:
        registry = Registry()
        registry.add(cls)
        json.dumps(make_schema("graph", registry), allow_nan=False)
    except Exception as error:  # whatever it is, the author has to know
        yield f"it cannot be described as JSON Schema: {error}"


def _behaviour(cls: type[Node], make: Callable[[], RecordingContext], inputs: Mapping[str, Any]) -> Iterator[str]:
    ports = [p for p in cls.fields.values() if p.side == "inputs" and (p.required or _has_no_type_yet(p))]
    given = {p.required for p in ports if p.field in inputs and isinstance(p.required, str)}
    needed = [p.field for p in ports if p.field not in inputs and p.required not in given]
    if needed:
        yield f"check_node needs values for required inputs: {', '.join(needed)}"
        return
    try:
        (one, again), (other, _) = (_two_plays(cls(**inputs), make()) for _ in range(2))
        if one != other:
            yield "two instances with the same inputs behave differently; take time and random numbers from the context"
        elif one != again:
            yield "it behaves differently after a stop; fields that setup assigns are Bound, others are State with a default"
    except Exception as error:  # whatever it is, the author has to know
        yield f"{type(error).__name__} in line {traceback.extract_tb(error.__traceback__)[-1].lineno}: {error}"


def _has_no_type_yet(port: Port) -> bool:
    return isinstance(port.type, UnionType) and port.default is None


def _two_plays(node: Any, context: RecordingContext) -> list[list[object]]:
    """Return the outputs and messages of a node in three ticks, and in three more after a stop, in a comparable form."""
    if hasattr(node, "__dict__"):
        raise TypeError("instances have a __dict__, which hides misspelt attributes; a base class lacks __slots__")
    record, again = plays = [list[object](), list[object]()]
    try:
        node.setup(context)
        for record, tick in itertools.product(plays, range(3)):
            if tick == 0 and record is again:
                context.clock.set_frame(0)  # before the stop, so that time since the session began repeats too
                context.stop(node)
            context.tick()
            sent = {claim.topic: len(context.transport.raw(claim.topic)) for claim in context.services.claims}
            for port in node.fields.values():
                if port.is_exec and port.side == "inputs" and not port.control:
                    setattr(node, port.field, 1)
            fired = node.compute()
            if node.kind() == "pusher":
                fired = list(itertools.islice(fired, 1000))
            elif fired is not None and not node.gated:
                raise TypeError("compute returns ports to fire, but the class is not gated=True")
            record += [fired, node.update() if node.kind() == "latent" and node.active else None]
            outputs = [getattr(node, p.field) for p in node.fields.values() if p.side == "outputs" and not p.is_exec]
            record += [(v.dtype.str, v.shape, v.tobytes()) if isinstance(v, np.ndarray) else repr(v) for v in outputs]
            record += [context.transport.raw(topic)[before:] for topic, before in sent.items()]
    except (ValueError, GraphError) as refusal:
        record.append(str(refusal))
    return plays if again else [record, record]
