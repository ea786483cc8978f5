"""Checks that a node class is documented, declared correctly and deterministic."""

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
from graphengine.node.node_class import REFUSALS, Node, NodeClassError
from graphengine.node.port import Port
from graphengine.node.types import UnionType
from graphengine.testing.recording_context import RecordingContext


def check_node(cls: type[Node], make: Callable[[], RecordingContext] = RecordingContext, /, **inputs: Any) -> None:
    """Check a node class; raise NodeClassError with a list of all problems.

    The class needs a docstring, documented ports, units of physical quantities, a unique name, valid defaults and ports that
    JSON Schema can describe. The check then runs two instances of the node, each for three ticks and, after a stop, for three
    more. Both instances must give the same outputs and messages, and each instance must give the same outputs and messages
    before and after the stop. The node is allowed to raise ValueError and GraphError.

    Args:
        cls: node class to check.
        make: function that returns a new context for an instance.
        inputs: input values by Python name of the port; all required inputs need a value.

    Raises:
        NodeClassError: the class has problems.
    """
    problems = [*_words(cls), *_shape(cls), *_behaviour(cls, make, inputs)]
    if problems:
        raise NodeClassError("\n  - ".join([f"{cls.__module__}.{cls.__qualname__} fails the node check:", *problems]))


_PHYSICAL = "acceleration angle delay distance dt duration effort force frequency length mass period position radius "
_PHYSICAL += "rate second speed stamp temperature time timeout torque translation velocity velocitie"


def _words(cls: type[Node]) -> Iterator[str]:
    first = (inspect.getdoc(cls) or "").partition("\n")[0] if cls.__doc__ else ""
    if not first.endswith(".") or re.match(r"(?i)(this|a node|the node|node that|class)\b", first):
        yield f"the first line of its docstring must say what the node does and end with a full stop, got {first!r}"
    for port in (port for port in cls.fields.values() if port.side != "state" and not port.is_exec):
        told = port.doc or port.unit or port.tokens or port.component or re.search(r"[A-Z_]", port.name)
        if not told and port.name.lower() not in cls.type_name.lower():
            yield f"{port.name}: a port whose name is one word needs a description, `doc=`"
        words = {word.removesuffix("s") for word in port.field.split("_")}
        real = str(port.type).startswith(("double", "float", "half", "vector"))
        if real and not port.unit and "type" not in words and words.intersection(_PHYSICAL.split()):
            yield f"{port.name}: a physical quantity needs a unit, `unit=`"


def _shape(cls: type[Node]) -> Iterator[str]:
    if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)+", cls.type_name):
        yield f"a type name needs several parts joined by dots, such as my_robots.Gripper; type= is {cls.type_name!r}"
    for name in (cls.type_name, *cls.aliases):
        if (other := default_registry().types.get(name, cls)) not in cls.__mro__:  # one may have grown ports
            yield f"the type name {name!r} belongs to {other.__module__}.{other.__qualname__}"
    named = [f"{port.side}:{port.name}" for port in cls.fields.values()]
    yield from (f"{named.count(name)} ports are called {name}" for name in sorted(set(named)) if named.count(name) > 1)
    for port in cls.fields.values():
        try:
            if port.side != "state" and not port.is_exec and not (port.required or port.unset):
                port.check(port.default)
        except (TypeError, ValueError) as error:
            yield f"{port.name}: the default {port.default!r} is not valid: {error}"
    try:
        registry = Registry()
        registry.add(cls)
        json.dumps(make_schema("graph", registry), allow_nan=False)
    except Exception as error:  # whatever it is, the author has to know
        yield f"the node cannot be described as JSON Schema: {error}"


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
            yield (
                "the node behaves differently after a stop; "
                "declare fields that setup assigns as Bound, and other fields as State with a default"
            )
    except Exception as error:  # whatever it is, the author has to know
        yield f"{type(error).__name__} in line {traceback.extract_tb(error.__traceback__)[-1].lineno}: {error}"


def _has_no_type_yet(port: Port) -> bool:
    return isinstance(port.type, UnionType) and port.default is None


def _two_plays(node: Any, context: RecordingContext) -> list[list[object]]:
    """Run a node for three ticks, stop it, and run it for three more ticks.

    Returns:
        Outputs and messages before the stop, and after the stop, as two lists that can be compared.
    """
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
                raise TypeError("compute returns ports to fire, but the class was not declared with gated=True")
            record += [fired, node.update() if node.kind() == "latent" and node.active else None]
            outputs = [getattr(node, p.field) for p in node.fields.values() if p.side == "outputs" and not p.is_exec]
            record += [(v.dtype.str, v.shape, v.tobytes()) if isinstance(v, np.ndarray) else repr(v) for v in outputs]
            record += [context.transport.raw(topic)[before:] for topic, before in sent.items()]
    except REFUSALS as refusal:
        record.append(str(refusal))
    return plays if again else [record, record]
