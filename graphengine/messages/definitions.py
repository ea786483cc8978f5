"""Looks up message types by their ROS names: their fields, Python classes and type hashes.

Known types are those of a distribution of ROS 2 (from rosbags; Jazzy unless another is chosen), those in `share/` beside this
file, and those in folders that a user gives. A definition file is read when its type is first used. A user's folders add types
but never change a known type, so the messages of a node do not depend on these folders.

The files in `share/` have only the fields and constants of their types, without comments. They define types of ackermann_msgs
2.0.2, vision_msgs 4.1.1, simulation_interfaces 1.5.1 and control_msgs 5.8.0 (trajectories, grippers, single joints), the
services of Isaac Sim's isaac_ros2_messages (github.com/isaac-sim/IsaacSim-ros_workspaces, jazzy_ws), and those types of Jazzy's
common interfaces that rosbags does not have: nav_msgs/Goals, services, and example_interfaces 0.12.0. A file in
`share_by_distro/DISTRO/` replaces the file in `share/` for DISTRO and later distributions: since Kilted (control_msgs 6.3.0),
the feedback of FollowJointTrajectory has the index of a trajectory point, and since Lyrical (nav2_msgs 1.5), the feedback of
NavigateToPose has two tracking errors.
"""

from __future__ import annotations

import itertools
import threading
from collections import ChainMap
from collections.abc import Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.interfaces import Msgdef, Nodetype
from rosbags.typesys.base import normalize_fieldname
from rosbags.typesys.store import TIDMAP, Typestore

from graphengine.format.wording import did_you_mean, listing, shown
from graphengine.messages import wide_strings
from graphengine.messages.distros import DISTROS, JAZZY, Distro, base_types
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
SHARE_BY_DISTRO = Path(__file__).parent / "share_by_distro"
MAX_NESTING = 32
"""Maximum depth of messages nested in messages."""
MAX_VALUES = 1_000_000
"""Maximum number of values in a message whose variable arrays are empty; each element of a fixed array counts as a value."""

_INITIAL: dict[str, dict[str, Any]] = {
    "geometry_msgs/msg/Quaternion": {"w": 1.0},
    "sensor_msgs/msg/NavSatStatus": {"status": -2},
}
"""Nonzero default values that ROS 2 defines for fields of these types; rosbags does not store default values."""
PLACEHOLDER = ("structure_needs_at_least_one_member", (Nodetype.BASE, ("uint8", 0)))
"""Name and type of the field that ROS 2 adds to a message without fields."""
_CHAR, _UINT8 = (Nodetype.BASE, ("char", 0)), (Nodetype.BASE, ("uint8", 0))
_CODED = (Nodetype.NAME, wide_strings.NAME)
"""Field type that stands for a wide string in a rosbags store."""
TIDMAP["wstring"] = 18  # of type_description_interfaces/msg/FieldType, which rosbags leaves out
_lock = threading.RLock()


class _Store(Typestore):
    """A rosbags store that extends another store, `below`: it also finds the types of `below` and uses their codecs."""

    def __init__(self, below: Typestore) -> None:
        super().__init__()
        self._below = below
        self.types = ChainMap({}, below.types)  # type: ignore[assignment]

    def get_msgdef(self, typename: str) -> Msgdef[object]:
        """Return the codec of a type of this store or the extended store, or of a wide string."""
        if typename == wide_strings.NAME:
            return wide_strings.CODEC
        return super().get_msgdef(typename) if typename in self.fielddefs else self._below.get_msgdef(typename)


class Definitions:
    """The definitions of all known message, service and action types; methods take the ROS names of types.

    Args:
        folders: folders with definition files.
        below: definitions that the folders extend; None: the types of `distro` in rosbags.
        distro: distribution of ROS 2; ignored if `below` is given.
    """

    def __init__(self, folders: Folders, below: Definitions | None = None, distro: Distro = JAZZY) -> None:
        self.distro: Distro = below.distro if below else distro
        """Distribution of ROS 2 whose types are known."""
        self.files: dict[str, Path] = {}
        """A dict from type names, such as `std_srvs/srv/Trigger`, to definition files that were read from users' folders."""
        self._folders = folders
        self._below = below
        self._sizes: dict[str, int] = {}
        self._hashes: dict[str, str] = {}

    @cached_property
    def store(self) -> Typestore:
        """The rosbags store that encodes and decodes the types used so far."""
        made = _Store(self._below.store) if self._below else Typestore(base_types(self.distro))
        kept: Typestore = vars(self).setdefault("store", made)  # the same one for threads that ask at once
        return kept

    @cached_property
    def _known(self) -> dict[str, Definition]:
        made: dict[str, Definition] = {}
        if self._below is None:
            for name, (constants, fields) in base_types(self.distro).FIELDDEFS.items():
                own = [field for field in fields if field[0] != PLACEHOLDER[0]]
                made[name] = Definition(list(constants), own, _INITIAL.get(name, {}))
        kept: dict[str, Definition] = vars(self).setdefault("_known", made)
        return kept

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle only the folders and the distribution; unpickling reads the definition files again."""
        if self is shipped(self.distro):
            return shipped, (self.distro,)
        return Definitions, (self._folders, self._below, self.distro)

    def for_distro(self, distro: Distro) -> Definitions:
        """Return the definitions of another distribution, extended by the same folders."""
        if distro == self.distro:
            return self
        if self._below is None or self is shipped(self.distro):
            return shipped(distro)
        return Definitions(self._folders, self._below.for_distro(distro))

    def extended(self, given: Sequence[Path] = (), installed: Sequence[Path] = ()) -> Definitions:
        """Return definitions that extend these by additional folders. The arguments are those of `Folders`."""
        return Definitions(Folders(given, installed), self) if given or installed else self

    def names(self) -> list[str]:
        """Return the names of all known types: messages, services and actions."""
        below = self._below.names() if self._below else ()
        return sorted({*below, *self._known, *self._folders.names()})

    def definition(self, message_type: str) -> Definition:
        """Return the definition of a message, service or action type.

        Raises:
            MessageTypeError: the type is unknown, its definition is invalid, or a folder defines it differently from ROS 2.
        """
        known = self._known.get(message_type)
        if known is None:
            with _lock:
                known = self._load(message_type, ())
        return known

    def message_class(self, message_type: str) -> type[Any]:
        """Return the dataclass of a message type.

        Raises:
            MessageTypeError: the same causes as for `definition`, or the type is a service or an action.
        """
        definition = self.definition(message_type)
        if not definition.is_message:
            hint = listing(_parts(definition.fields), "it has")
            raise MessageTypeError(f"{message_type} is not a message type", message_type.rpartition("/")[2], hint)
        return self.store.types[message_type]

    def service_parts(self, service_type: str) -> tuple[str, str]:
        """Return the names of the request and response types of a service type, such as `std_srvs/srv/Trigger_Request`.

        Raises:
            MessageTypeError: the same causes as for `definition`, or the type is not a service.
        """
        request, response = f"{service_type}_Request", f"{service_type}_Response"
        named = [part for part in _parts(self.definition(service_type).fields) if part in (request, response)]
        if self.definition(service_type).is_message or len(named) != 2:
            raise MessageTypeError(f"{service_type} is not a service type", service_type.rpartition("/")[2])
        return request, response

    def action_parts(self, action_type: str) -> tuple[str, str, str]:
        """Return the names of an action type's goal, result and feedback types, such as `tf2_msgs/action/LookupTransform_Goal`.

        Raises:
            MessageTypeError: the same causes as for `definition`, or the type is not an action.
        """
        goal, result, feedback = (f"{action_type}_{part}" for part in ("Goal", "Result", "Feedback"))
        definition = self.definition(action_type)
        if definition.is_message or not {goal, result, feedback} <= set(_parts(definition.fields)):
            raise MessageTypeError(f"{action_type} is not an action type", action_type.rpartition("/")[2])
        return goal, result, feedback

    def fields(self, message_type: str) -> list[Field]:
        """Return the attribute name and the type of each field; a name that is a Python keyword gets a trailing `_`."""
        return [(normalize_fieldname(name), kind) for name, kind in self.definition(message_type).fields]

    def initial(self, message_type: str) -> Any:
        """Return a new message. Fields without a default value in the definition are zeros, empty strings or empty arrays."""
        fields, given = self.definition(message_type).fields, self.definition(message_type).initial
        return self.message_class(message_type)(*(self._initial(kind, given.get(name)) for name, kind in fields))

    def type_hash(self, message_type: str) -> str:
        """Return the REP 2011 hash of a type. Peers compare their definitions of the type by this hash.

        Raises:
            MessageTypeError: the type is unknown.
        """
        if message_type not in self._hashes:
            store = Typestore()
            for name in self.closure(message_type):
                # In ROS 2 `char` is an alias of `uint8`; rosbags hashes it as a type of its own.
                store.fielddefs[name] = ([], _replaced(self.definition(name).fields, _CHAR, _UINT8))
            self._hashes[message_type] = store.hash_rihs01(message_type)
        return self._hashes[message_type]

    def agrees(self, message_type: str, type_hash: str) -> bool:
        """Return whether a peer's hash of a type equals the own hash; true if the peer's hash is not of version RIHS01."""
        return not type_hash.startswith("RIHS01_") or type_hash == self.type_hash(message_type)

    def is_wide(self, message_type: str) -> bool:
        """Return whether a type or one of its nested types contains wide strings."""
        fields = (field for name in self.closure(message_type) for _, field in self.definition(name).fields)
        return any(element_of(field) == WIDE for field in fields)

    def text(self, message_type: str) -> str:
        """Return the definitions of a message and its nested types as text, in MCAP's format `ros2msg`.

        Raises:
            MessageTypeError: the type is unknown.
        """
        whole, *parts = self.closure(message_type)
        sections = [f"{'=' * 80}\nMSG: {part.replace('/msg/', '/')}\n{self.definition(part)}" for part in parts]
        return "".join([str(self.definition(whole)), *sections])

    def closure(self, message_type: str) -> list[str]:
        """Return the name of the given type, then the names of all types nested in it."""
        names = [message_type]
        for name in names:  # which grows
            names += dict.fromkeys(part for part in _parts(self.definition(name).fields) if part not in names)
        return names

    def _load(self, message_type: str, within: tuple[str, ...]) -> Definition:
        """Load a type and its nested types, and return its definition.

        `within` lists the types in which the type is nested, outermost first.
        """
        if message_type in self._known:
            return self._known[message_type]
        name, file = TypeName.parse(message_type), self._file(message_type)
        found = read(file, name) if name and file else {}
        if self._below is not None and self._below._has(message_type):
            known = self._below.definition(message_type)
            if message_type in found and known.fields != found[message_type].fields:
                raise self._another(message_type, known, found[message_type], file)
            return self._known.setdefault(message_type, known)
        if message_type not in found:
            raise self._unknown(message_type, within, found)
        parts = {part: None for definition in found.values() for part in _parts(definition.fields)}
        if len(within) == MAX_NESTING or message_type in (*within, *_parts(found[message_type].fields)):
            chain = " in ".join((message_type, *reversed(within[-3:])))
            raise MessageTypeError(f"{file}: messages contain each other without end: {chain}", name and name.name)
        for part in parts:
            if part not in found:
                self._load(part, (*within, message_type))
        self._add(found, file)
        if name and file and not any(map(file.is_relative_to, (SHARE, SHARE_BY_DISTRO))):
            self.files[name.source] = file
        return found[message_type]

    def _add(self, found: dict[str, Definition], file: Path | None) -> None:
        """Register the types found in a file; all nested types must be known already."""
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
        """Raise MessageTypeError if a type has too many values or an invalid default value."""
        if self._size(name) > MAX_VALUES:
            raise MessageTypeError(f"{file}: a {name} has more than {MAX_VALUES} values", name.rpartition("/")[2])
        kinds = dict(definition.fields)
        for field, value in definition.initial.items():
            try:
                fault = find_fault(self._initial(kinds[field], value), kinds[field], field, self.fields)
            except (TypeError, ValueError, OverflowError) as error:
                fault = f"{field} cannot be {value!r}: {error}"
            if fault:
                raise MessageTypeError(f"{file}: invalid default value: {fault}", name.rpartition("/")[2])

    def _size(self, name: str) -> int:
        """Return the number of values in a message whose variable arrays are empty."""
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
                raise OverflowError(f"a value is outside the range of {number}")  # numpy 1 only warns
            return np.array(values, dtype)
        return [self._initial(element, None) for _ in range(length)] if given is None else list(given)

    def _file(self, message_type: str) -> Path | None:
        name = TypeName.parse(message_type)
        return self._folders.find(name) if name else None

    def _has(self, message_type: str) -> bool:
        is_below = self._below is not None and self._below._has(message_type)
        return is_below or message_type in self._known or self._file(message_type) is not None

    def _unknown(self, message_type: str, within: Sequence[str], found: dict[str, Definition]) -> MessageTypeError:
        """Return the error for an unknown type, with similar names and a remedy."""
        what = f"no message type {shown(message_type)}" + (f", which {within[-1]} contains" if within else "")
        package, _, last = message_type.rpartition("/")
        if found:
            return MessageTypeError(what, last, listing(found, "known are"))
        names = self.names()
        siblings = [name.rpartition("/")[2] for name in names if name.rpartition("/")[0] == package]
        if siblings:
            return MessageTypeError(what, last, did_you_mean(last, siblings) or listing(siblings, package))
        namesakes = [name for name in names if name.rpartition("/")[2] == last]
        remedy = "give the folder of its package with --msg-path, or source the workspace in which it is installed"
        return MessageTypeError(what, message_type.partition("/")[0], did_you_mean(message_type, namesakes), remedy)

    def _another(self, message_type: str, known: Definition, other: Definition, file: Path | None) -> MessageTypeError:
        """Return the error for a type that a user's file defines differently from the distribution."""
        pairs = itertools.zip_longest(known.fields, other.fields)
        ours, theirs = next((pair for pair in pairs if pair[0] != pair[1]), (None, None))
        field = (theirs or ours or ("", ()))[0]
        return MessageTypeError(
            f"{file} differs from ROS 2 {self.distro.title()}'s definition of {message_type} in {field!r}",
            message_type.rpartition("/")[2],
            "choose the distribution of the file with --distro, or rename the type or its package",
        )


def _replaced(fields: Sequence[Field], old: Description, new: Description) -> list[Field]:
    """Return fields with the type `new` in place of `old`, also as the element type of arrays."""
    return [(name, replace_element(kind, lambda element: new if element == old else element)) for name, kind in fields]


def dtype_of(number: str) -> np.dtype[Any]:
    """Return the dtype of arrays of a ROS number type; `byte` is int8, because rosbags represents it as a signed number."""
    return np.dtype({"byte": "int8", "char": "uint8"}.get(number, number))


def _parts(fields: Sequence[Field]) -> list[str]:
    """Return the names of the message types of all fields, and of the elements of all arrays."""
    elements = [element_of(kind) for _, kind in fields]
    return [detail for kind, detail in elements if kind == Nodetype.NAME]


@cache
def shipped(distro: Distro) -> Definitions:
    """Return the definitions of a distribution from rosbags and `share/`, without a user's folders; the result never changes."""
    since = DISTROS[: DISTROS.index(distro) + 1]
    replaced = [SHARE_BY_DISTRO / name for name in reversed(since)]
    return Definitions(Folders(), distro=distro).extended(installed=[*filter(Path.is_dir, replaced), SHARE])


DEFINITIONS = shipped(JAZZY)
"""Definitions of Jazzy from rosbags and `share/`: the default of functions with the argument `definitions`."""
