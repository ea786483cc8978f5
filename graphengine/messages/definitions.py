"""Message types by their ROS names: their fields, their Python classes and their type hashes.

Known are the types of ROS 2 Jazzy (from rosbags), those below `share/` beside this file, and those of folders that a user
names; files are read when a type is first asked for. Folders add types. They never give another meaning to one that is there
without them, so what a node publishes does not depend on them.

Below `share/` are the bare fields and constants of ackermann_msgs 2.0.2, vision_msgs 4.1.1, simulation_interfaces 1.5.1, of the
services of Isaac Sim's isaac_ros2_messages (github.com/isaac-sim/IsaacSim-ros_workspaces, jazzy_ws), and of what rosbags leaves
out of Jazzy's common interfaces: nav_msgs/Goals and services.
"""

from __future__ import annotations

import itertools
import threading
from collections import ChainMap
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Msgdef, Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import TIDMAP, Typestore

from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages import wide_strings
from graphengine.messages.folders import Folders
from graphengine.messages.interfaces import (
    TEXTS,
    WIDE,
    Definition,
    Description,
    Field,
    MessageTypeError,
    TypeName,
    element_of,
    read,
    replace_element,
    signed_byte,
)
from graphengine.messages.message_validation import find_fault

SHARE = Path(__file__).parent / "share"
MAX_NESTING = 32
"""Messages within messages."""
MAX_VALUES = 1_000_000
"""Values that a message has at least: its fields and what stands in its arrays of fixed length."""

_INITIAL: dict[str, dict[str, Any]] = {
    "geometry_msgs/msg/Quaternion": {"w": 1.0},
    "sensor_msgs/msg/NavSatStatus": {"status": -2},
}
"""What fields of Jazzy's own types hold before anybody writes to them, where it is not zero; rosbags does not keep it."""
PLACEHOLDER = ("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0)))
"""The field that ROS 2 gives to a message without any, and its type."""
_CHAR, _UINT8 = (Nodetype.BASE, ("char", 0)), (Nodetype.BASE, ("uint8", 0))
_CODED = (Nodetype.NAME, wide_strings.NAME)
"""A wide string as a store of rosbags takes it."""
TIDMAP["wstring"] = 18  # of type_description_interfaces/msg/FieldType, which rosbags leaves out
_lock = threading.RLock()


def _jazzy() -> Any:
    """The types of ROS 2 Jazzy; importing them takes 50 ms, and most graphs are checked without."""
    from rosbags.typesys.stores import ros2_jazzy

    return ros2_jazzy


class _Store(Typestore):
    """Types, and the codecs of those in another store."""

    def __init__(self, below: Typestore) -> None:
        super().__init__()
        self._below = below
        self.types = ChainMap({}, below.types)  # type: ignore[assignment]

    def get_msgdef(self, typename: str) -> Msgdef[object]:
        """What encodes and decodes a type."""
        if typename == wide_strings.NAME:
            return wide_strings.CODEC
        return super().get_msgdef(typename) if typename in self.fielddefs else self._below.get_msgdef(typename)


class Definitions:
    """Message types by name: those of folders, and others below them.

    Args:
        folders: where definitions are looked for.
        below: what is known without them; None for ROS 2 Jazzy's own types and no others.
    """

    def __init__(self, folders: Folders, below: Definitions | None = None) -> None:
        self.files: dict[str, Path] = {}
        """Files of the users' folders that were read, by what they define, as in `std_srvs/srv/Trigger`."""
        self._folders = folders
        self._below = below
        self._sizes: dict[str, int] = {}
        self._hashes: dict[str, str] = {}

    @cached_property
    def store(self) -> Typestore:
        """Encodes and decodes the types that were asked for."""
        made = _Store(self._below.store) if self._below else Typestore(_jazzy())
        kept: Typestore = vars(self).setdefault("store", made)  # the same one for threads that ask at once
        return kept

    @cached_property
    def _known(self) -> dict[str, Definition]:
        made: dict[str, Definition] = {}
        if self._below is None:
            for name, (constants, fields) in _jazzy().FIELDDEFS.items():
                own = [field for field in fields if field[0] != PLACEHOLDER[0]]
                made[name] = Definition(list(constants), own, _INITIAL.get(name, {}))
        kept: dict[str, Definition] = vars(self).setdefault("_known", made)
        return kept

    def __reduce__(self) -> str | tuple[Any, ...]:
        """Pickle the folders; another process reads their files again."""
        return "DEFINITIONS" if self is DEFINITIONS else (Definitions, (self._folders, self._below))

    def extended(self, given: Sequence[Path] = (), installed: Sequence[Path] = ()) -> Definitions:
        """These and the types of folders; see `Folders`."""
        return Definitions(Folders(given, installed), self) if given or installed else self

    def names(self) -> list[str]:
        """Every type that is there: messages, services and actions."""
        below = self._below.names() if self._below else ()
        return sorted({*below, *self._known, *self._folders.names()})

    def definition(self, message_type: str) -> Definition:
        """What a message, service or action consists of.

        Raises:
            MessageTypeError: there is no such type, its definition cannot be used, or a folder has another one of it.
        """
        known = self._known.get(message_type)
        if known is None:
            with _lock:
                known = self._load(message_type, ())
        return known

    def message_class(self, message_type: str) -> type[Any]:
        """The dataclass of a message.

        Raises:
            MessageTypeError: as for `definition`, or it is a service or an action.
        """
        definition = self.definition(message_type)
        if not definition.is_message:
            hint = listing(_parts(definition.fields), "it has")
            raise MessageTypeError(f"{message_type} is no message", message_type.rpartition("/")[2], hint)
        return self.store.types[message_type]

    def service_parts(self, service_type: str) -> tuple[str, str]:
        """Names of the messages that ask and answer, as in `std_srvs/srv/Trigger_Request`.

        Raises:
            MessageTypeError: as for `definition`, or it is no service.
        """
        request, response = f"{service_type}_Request", f"{service_type}_Response"
        named = [part for part in _parts(self.definition(service_type).fields) if part in (request, response)]
        if self.definition(service_type).is_message or len(named) != 2:
            raise MessageTypeError(f"{service_type} is no service", service_type.rpartition("/")[2])
        return request, response

    def fields(self, message_type: str) -> list[Field]:
        """Attributes of a message, and their types; where ROS's name is a keyword of Python, a `_` follows it."""
        return [(normalize_fieldname(name), kind) for name, kind in self.definition(message_type).fields]

    def initial(self, message_type: str) -> Any:
        """A message as ROS 2 makes it: what its definition says for a field, else zeros, empty texts and empty arrays."""
        fields, given = self.definition(message_type).fields, self.definition(message_type).initial
        return self.message_class(message_type)(*(self._initial(kind, given.get(name)) for name, kind in fields))

    def type_hash(self, message_type: str) -> str:
        """The REP 2011 hash of a message, service or action, by which peers tell versions of a definition apart.

        Raises:
            MessageTypeError: there is no such type.
        """
        if message_type not in self._hashes:
            store = Typestore()
            for name in self._closure(message_type):
                # In ROS 2 `char` is an alias of `uint8`; rosbags hashes it as a type of its own.
                store.fielddefs[name] = ([], _replaced(self.definition(name).fields, _CHAR, _UINT8))
            self._hashes[message_type] = store.hash_rihs01(message_type)
        return self._hashes[message_type]

    def agrees(self, message_type: str, type_hash: str) -> bool:
        """Whether a peer's hash of a type is that of the definition here; true where the peer has none of this version."""
        return not type_hash.startswith("RIHS01_") or type_hash == self.type_hash(message_type)

    def is_wide(self, message_type: str) -> bool:
        """Whether there are wide strings in a type."""
        fields = (field for name in self._closure(message_type) for _, field in self.definition(name).fields)
        return any(element_of(field) == WIDE for field in fields)

    def text(self, message_type: str) -> str:
        """The definition of a message and of its parts as recordings keep it; MCAP calls the form `ros2msg`.

        Raises:
            MessageTypeError: there is no such type.
        """
        whole, *parts = self._closure(message_type)
        sections = [f"{'=' * 80}\nMSG: {part.replace('/msg/', '/')}\n{self.definition(part)}" for part in parts]
        return "".join([str(self.definition(whole)), *sections])

    def _closure(self, message_type: str) -> list[str]:
        """A type, and then all that it consists of."""
        names = [message_type]
        for name in names:  # which grows
            names += dict.fromkeys(part for part in _parts(self.definition(name).fields) if part not in names)
        return names

    def _load(self, message_type: str, within: tuple[str, ...]) -> Definition:
        """Find a type and all that it consists of; `within` are the types that it is part of."""
        if message_type in self._known:
            return self._known[message_type]
        name, file = TypeName.parse(message_type), self._file(message_type)
        found = read(file, name) if name and file else {}
        if self._below is not None and self._below._has(message_type):
            known = self._below.definition(message_type)
            if message_type in found and known.fields != found[message_type].fields:
                raise _another(message_type, known, found[message_type], file)
            return self._known.setdefault(message_type, known)
        if message_type not in found:
            raise self._unknown(message_type, within, found)
        parts = {part: None for definition in found.values() for part in _parts(definition.fields)}
        if len(within) == MAX_NESTING or message_type in (*within, *_parts(found[message_type].fields)):
            chain = " in ".join((message_type, *reversed(within[-3:])))
            raise MessageTypeError(f"{file}: messages lie within each other without end: {chain}", name and name.name)
        for part in parts:
            if part not in found:
                self._load(part, (*within, message_type))
        self._add(found, file)
        if name and file and not file.is_relative_to(SHARE):
            self.files[name.source] = file
        return found[message_type]

    def _add(self, found: dict[str, Definition], file: Path | None) -> None:
        """Know the types of a file, whose parts are known already."""
        self._known |= found
        try:
            for name, definition in found.items():
                self._check(name, definition, file)
            coded = {n: (d.constants, _replaced(d.fields, WIDE, _CODED)) for n, d in found.items() if d.is_message}
            self.store.register(coded)  # type: ignore[arg-type]
        except BaseException:
            for name in found:
                del self._known[name]
            raise

    def _check(self, name: str, definition: Definition, file: Path | None) -> None:
        """Refuse a type of which not even one message could be made."""
        if self._size(name) > MAX_VALUES:
            raise MessageTypeError(f"{file}: a {name} has more than {MAX_VALUES} values", name.rpartition("/")[2])
        kinds = dict(definition.fields)
        for field, value in definition.initial.items():
            try:
                fault = find_fault(self._initial(kinds[field], value), kinds[field], field, self.fields)
            except (TypeError, ValueError, OverflowError) as error:
                fault = f"{field} cannot be {value!r}: {error}"
            if fault:
                raise MessageTypeError(f"{file}: {fault}, and so it is by default", name.rpartition("/")[2])

    def _size(self, name: str) -> int:
        """How many values a message has at least."""
        if name not in self._sizes:
            self._sizes[name] = sum(self._size_of(kind) for _, kind in self.definition(name).fields) or 1
        return self._sizes[name]

    def _size_of(self, description: Description) -> int:
        kind, detail = description
        if kind == Nodetype.NAME:
            return self._size(detail)
        return int(detail[1]) * self._size_of(detail[0]) if kind == Nodetype.ARRAY else 1

    def _initial(self, description: Description, given: Any) -> Any:
        kind, detail = description
        if kind == Nodetype.NAME:
            return self.initial(detail)
        if kind == Nodetype.BASE:
            zero = "" if detail[0] in TEXTS else dtype_of(detail[0]).type(0).item()
            if given is None:
                return zero
            return signed_byte(given) if detail[0] == "byte" else type(zero)(given)
        element, count = detail
        length = count if kind == Nodetype.ARRAY else 0
        if element[0] == Nodetype.BASE and element[1][0] not in TEXTS:
            number, dtype = element[1][0], dtype_of(element[1][0])
            if given is None:
                return np.zeros(length, dtype)
            values = [signed_byte(value) for value in given] if number == "byte" else given
            if dtype.kind in "iu" and any(not np.iinfo(dtype).min <= value <= np.iinfo(dtype).max for value in values):
                raise OverflowError(f"not all are of type {number}")  # numpy 1 only warns
            return np.array(values, dtype)
        return [self._initial(element, None) for _ in range(length)] if given is None else list(given)

    def _file(self, message_type: str) -> Path | None:
        name = TypeName.parse(message_type)
        return self._folders.find(name) if name else None

    def _has(self, message_type: str) -> bool:
        is_below = self._below is not None and self._below._has(message_type)
        return is_below or message_type in self._known or self._file(message_type) is not None

    def _unknown(self, message_type: str, within: Sequence[str], found: dict[str, Definition]) -> MessageTypeError:
        """No such type: what is near, and what to do."""
        what = f"no message type {shown(message_type)}" + (f", of which {within[-1]} consists" if within else "")
        package, _, last = message_type.rpartition("/")
        if found:
            return MessageTypeError(what, last, listing(found, "known are"))
        names = self.names()
        siblings = [name.rpartition("/")[2] for name in names if name.rpartition("/")[0] == package]
        if siblings:
            return MessageTypeError(what, last, did_you_mean(last, siblings) or listing(siblings, package))
        namesakes = [name for name in names if name.rpartition("/")[2] == last]
        remedy = "name the folder of its package with --msg-path, or source the workspace that it is installed in"
        return MessageTypeError(what, message_type.partition("/")[0], did_you_mean(message_type, namesakes), remedy)


def _replaced(fields: Sequence[Field], old: Description, new: Description) -> list[Field]:
    """Fields with another type in place of one, in arrays too."""
    return [(name, replace_element(kind, lambda element: new if element == old else element)) for name, kind in fields]


def another_definition(name: str, peer: str, message_type: str, own: str, effect: str = "") -> tuple[str, str]:
    """What to say of a peer on a topic or service whose definition of its type is not the one here, and the remedy."""
    package = message_type.partition("/")[0]
    return (
        f"{name}: {peer} has another definition of {message_type} than {own}: {effect or 'nothing crosses'}",
        f"use one version of {package} on both sides; --msg-path names the folder of its definitions",
    )


def dtype_of(number: str) -> np.dtype[Any]:
    """What arrays of a kind of number consist of; rosbags takes a byte for signed."""
    return np.dtype({"byte": "int8", "char": "uint8"}.get(number, number))


def _another(message_type: str, known: Definition, other: Definition, file: Path | None) -> MessageTypeError:
    pairs = itertools.zip_longest(known.fields, other.fields)
    ours, theirs = next((pair for pair in pairs if pair[0] != pair[1]), (None, None))
    field = (theirs or ours or ("", ()))[0]
    return MessageTypeError(
        f"{file} is not the definition of {message_type} that peers of ROS 2 Jazzy have: {field!r} differs",
        message_type.rpartition("/")[2],
        "give the type, or its package, another name",
    )


def _parts(fields: Sequence[Field]) -> list[str]:
    """The messages that a type consists of."""
    elements = [element_of(kind) for _, kind in fields]
    return [detail for kind, detail in elements if kind == Nodetype.NAME]


DEFINITIONS = Definitions(Folders()).extended(installed=[SHARE])
"""What is known without folders of a user. Nothing is ever added to it."""
