"""The ScriptNode of `omni.graph.scriptnode`, which runs Python code in a graph.

In a graph file, a node with a script looks like this:

    Double:
      type: ScriptNode
      inputs:
        attributes: ["inputs:speed double", "outputs:command double[]"]
        script: |
          def compute(db):
              db.outputs.command = [db.inputs.speed, db.inputs.speed]

Scripts run without a sandbox, so they need the option `--allow-scripts`. Without this option, `graphrun check` reports an error.
"""

from __future__ import annotations

import copy
import linecache
import sys
import types as python
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal

import numpy as np

from graphengine.format.wording import did_you_mean, listing
from graphengine.messages.definitions import Definitions
from graphengine.node import Bound, Context, ContextError, ExecIn, ExecOut, Fire, In, Node, Out, types
from graphengine.node.port import Port
from graphengine.node.types import PortType, String, Token, Tokens, read_only

Log = Callable[[Literal["info", "warning", "error"], str], None]
_ALL = f"{types.ELEMENTS}|string|target|{types.ARRAYS}"
"""All types of values as one union."""


class Attributes(python.SimpleNamespace):
    """The values of the declared inputs or outputs of a ScriptNode, as Python attributes, for example `db.inputs.speed`."""

    def __getattr__(self, name: str) -> Any:
        """Report that the node declares no attribute with this name; Python calls this method only for missing attributes.

        Raises:
            AttributeError: always.
        """
        near = did_you_mean(name, vars(self)) or listing(vars(self), "declared")
        raise AttributeError(f"the node declares no attribute {name!r}; {near}")


class Database:
    """The argument `db` of a script's functions: inputs, outputs and state of the node.

    Attributes:
        inputs: values of the declared inputs, as attributes with the inputs' names; arrays are read-only.
        outputs: values of the declared outputs, as attributes with the outputs' names; the script sets them, and the node copies
            them to its outputs after `compute`.
        per_instance_state: namespace for the attributes in which the script stores its state; a stop clears it.
        internal_state: another name of `per_instance_state`.
    """

    def __init__(self, log: Log) -> None:
        self.inputs = Attributes()
        self.outputs = Attributes()
        self.per_instance_state = self.internal_state = python.SimpleNamespace()
        self._log = log

    def log_info(self, message: object) -> None:
        """Log a message with the severity `info`."""
        self._log("info", str(message))

    def log_warning(self, message: object) -> None:
        """Log a message with the severity `warning`."""
        self._log("warning", str(message))

    def log_error(self, message: object) -> None:
        """Log a message with the severity `error`. The run continues."""
        self._log("error", str(message))

    log_warn = log_warning


class ScriptNode(Node, type="omni.graph.scriptnode.ScriptNode", gated=True):
    """Runs a Python script.

    The node calls the script's functions `setup(db)` before the first execution, `compute(db)` at each execution and
    `cleanup(db)` at stop. It fires `execOut` unless `compute` returns False. `attributes` declares inputs and outputs, which the
    script finds in `db.inputs` and `db.outputs`. An execution input is 1 if it led to this execution, otherwise 0; the node fires
    each declared execution output that the script sets to True. Ports of the type `any` get their types from their wires.
    """

    exec_in = ExecIn()
    script: String = In(default="", setup=True, doc="Python code; used if `usePath` is false")
    use_path: bool = In(default=False, setup=True, doc="true: run the file `scriptPath`; false: run `script`")
    script_path: Token = In(
        default="",
        setup=True,
        doc="path of a file with Python code, relative to the graph file's folder; used if `usePath` is true",
    )
    attributes: Tokens = In(
        default=(), extension=True, doc='ports to declare, such as "inputs:speed double" or "outputs:command double[]"'
    )
    exec_out = ExecOut()

    code: python.CodeType = Bound()
    log: Log = Bound()
    running: tuple[dict[str, Any], Database] | None = Bound()

    @classmethod
    def dynamic_ports(cls, literals: Mapping[str, Any], definitions: Definitions) -> Mapping[str, Any]:
        """Return a dict from Python names to the inputs and outputs that `attributes` declares.

        Raises:
            ValueError: a declaration is invalid, or the node already has a port with the declared name.
        """
        declared = literals.get("attributes", ())
        fields: dict[str, Any] = {}
        for text in declared if isinstance(declared, list | tuple) else ():
            side, name, port_type = _declaration(text)
            if f"{side}:{name}" in cls.ports or f"{side}_{name}" in fields:
                raise ValueError(f"{text!r}: the port {side}:{name} already exists")
            fields[f"{side}_{name}"] = _field(side, name, port_type)
        return fields

    def setup(self, context: Context) -> None:
        """Compile the script.

        Raises:
            ContextError: the user does not allow scripts, the file cannot be read, or the script has a syntax error.
        """
        self.running = None
        context.allow_scripts()
        name, text = f"<script of {context.prim_path}>", self.script
        if self.use_path:
            path, text = context.read_file(self.script_path)
            name = str(path)
        try:
            self.code = compile(text, name, "exec", dont_inherit=True)
        except (SyntaxError, ValueError) as error:
            line = f" line {error.lineno}:" if isinstance(error, SyntaxError) and error.lineno else ""
            what = error.msg if isinstance(error, SyntaxError) else error
            raise ContextError(f"{name}:{line} {what}", self.script_path if self.use_path else self.script) from None
        linecache.cache[name] = (len(text), None, text.splitlines(keepends=True), name)
        self.log = context.log
        context.when_closed(self.reset)

    def compute(self) -> Fire:
        """Call the script's `compute`; before the first call, run the script's code and call its `setup`.

        Raises:
            RuntimeError: the script raised an exception; the message names the line of the script.
            TypeError: the script set an undeclared output, or set an output to a value of the wrong type.
            ValueError: the script set an output to a value out of range.
        """
        first = self.running is None
        namespace, db = self.running = self.running or ({"__name__": "__script__"}, Database(self.log))
        for port in declared(self, "inputs"):
            value = getattr(self, port.field)
            value = int(value > 0) if port.is_exec else value
            setattr(db.inputs, port.name, read_only(value.view()) if isinstance(value, np.ndarray) else value)
        for port in declared(self, "outputs"):
            setattr(db.outputs, port.name, 0 if port.is_exec else getattr(self, port.field))
        db.inputs.execIn, db.outputs.execOut = int(self.exec_in > 0), 1
        if first:
            self._call(exec, self.code, namespace)
            self._call_own("setup")
        if self._call_own("compute") is False:
            return None
        return self._take(db)

    def _take(self, db: Database) -> int:
        """Copy the outputs of the script to the node; return the execution outputs that it set, joined by `|`."""
        ports, fired = {port.name: port for port in type(self).fields.values() if port.side == "outputs"}, 0
        for name, value in vars(db.outputs).items():
            if name not in ports:
                hint = did_you_mean(name, ports) or listing(ports, "outputs")
                remedy = f'add "outputs:{name} double" to attributes'
                raise TypeError(f"db.outputs.{name} is not a declared output; {remedy}; {hint}")
            field = ports[name].field
            if ports[name].is_exec:
                fired |= getattr(self, field) if value else 0
                continue
            port_type = self.settled.get(field, ports[name].type)
            try:
                setattr(self, field, types.coerce(value, port_type) if isinstance(port_type, PortType) else value)
            except (TypeError, ValueError) as error:
                raise type(error)(f"db.outputs.{name} has the type {port_type}: {error}, got {value!r}") from None
        return fired

    def save(self) -> Any:
        """Return the port values of the node, copies of the script's variables and copies of the state in `db`.

        Raises:
            TypeError: a variable of the script, such as an open file, cannot be copied.
        """
        return super().save(), self.running, _copied(self.running) if self.running is not None else ()

    def restore(self, saved: Any) -> None:
        """Restore a state that `save` returned: the port values, the script's variables and the state in `db`."""
        values, self.running, kept = saved
        super().restore(values)
        if self.running is not None:
            for place, variables in zip(_places(self.running), _copied(self.running, kept), strict=True):
                place.clear()
                place.update(variables)

    def reset(self) -> None:
        """Call the script's `cleanup` if the script has run, and discard the state of the script."""
        if self.running is not None:
            try:
                self._call_own("cleanup")
            finally:
                self.running = None

    def _call_own(self, name: str) -> Any:
        """Call the script's function with this name and return its result; None if the script does not define the function."""
        assert self.running is not None
        namespace, db = self.running
        function = namespace.get(name)
        return self._call(function, db) if callable(function) else None

    def _call(self, function: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return function(*arguments)
        except (Exception, SystemExit) as error:
            lines, traceback = [self.code.co_firstlineno], error.__traceback__
            while traceback is not None:
                if traceback.tb_frame.f_code.co_filename == self.code.co_filename:
                    lines.append(traceback.tb_lineno)
                traceback = traceback.tb_next
            text = linecache.getline(self.code.co_filename, lines[-1]).strip()
            where = f"{self.code.co_filename}, line {lines[-1]}{f' ({text})' if text else ''}"
            raise RuntimeError(f"{where}: {type(error).__name__}: {error}") from error


_Running = tuple[dict[str, Any], Database]


def _places(running: _Running) -> list[dict[str, Any]]:
    """Return the dictionaries that hold a script's state: its global variables, inputs, outputs and `per_instance_state`."""
    namespace, db = running
    return [namespace, *(vars(part) for part in (db.inputs, db.outputs, db.per_instance_state))]


def _copied(running: _Running, kept: Sequence[dict[str, Any]] | None = None) -> list[dict[str, Any]]:
    """Return copies of the dictionaries in `kept`, or of the dictionaries that hold the script's current state.

    References to modules, to `db` and to its parts stay references to the same objects.

    Raises:
        TypeError: a variable of the script cannot be copied.
    """
    own = (running[1], running[1].inputs, running[1].outputs, running[1].per_instance_state)
    memo: dict[int, Any] = {id(one): one for one in (*sys.modules.values(), *own)}
    copied: list[dict[str, Any]] = [{} for _ in _places(running)]
    for into, place in zip(copied, kept or _places(running), strict=True):
        for name, value in place.items():
            try:
                into[name] = value if name == "__builtins__" else copy.deepcopy(value, memo)
            except Exception as error:  # a value of the script may refuse in any way
                raise TypeError(f"the script's variable {name} cannot be saved in a checkpoint: {error}") from error
    return copied


def declared(node: ScriptNode, side: Literal["inputs", "outputs"]) -> list[Port]:
    """Return the inputs or the outputs that the `attributes` of a script node declare."""
    own = ScriptNode.fields
    return [port for field, port in type(node).fields.items() if port.side == side and field not in own]


def _field(side: str, name: str, port_type: PortType | types.UnionType) -> Any:
    """Return the field of a declared port. An output of type `any` is a union of all types; its wires determine the type."""
    doc = "declared in `attributes`"
    if port_type == types.EXECUTION:
        return (ExecIn if side == "inputs" else ExecOut)(name=name, doc=doc)
    if side == "inputs":
        return In(type=str(port_type), name=name, doc=doc)
    return Out(type=_ALL if port_type == types.ANY else str(port_type), name=name, doc=doc)


def _declaration(text: object) -> tuple[str, str, PortType | types.UnionType]:
    """Return the side (`inputs` or `outputs`), the name and the type in a declaration such as `inputs:speed double`.

    Raises:
        ValueError: the text is not a declaration of this form, or the declared port is a bundle.
    """
    path, _, type_name = text.partition(" ") if isinstance(text, str) else ("", "", "")
    side, _, name = path.partition(":")
    if side not in ("inputs", "outputs") or not name.isidentifier() or name.startswith("_"):
        example = '"inputs:speed double" or "outputs:command double[]"'
        raise ValueError(f"{text!r} declares no attribute; write a declaration such as {example}")
    port_type = types.parse(type_name.strip())
    if port_type == types.parse("bundle"):
        raise ValueError(f"{text!r}: a script cannot have a bundle; declare one attribute for each value")
    return side, name, port_type
