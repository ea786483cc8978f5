"""Reads controllers from a ros2_control parameter file, such as `ros2_controllers.yaml`.

Parameters may be nested or have dotted names, and the section of a node may be below `/**` or a namespace. ROS 1 files, whose
sections have no `ros__parameters`, are read too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from graphengine.descriptions.robot_files.draft import Draft
from graphengine.format.diagnostics import Findings, Span
from graphengine.format.document import Document, Value, load
from graphengine.format.wording import printable

_PARAMETERS = "ros__parameters"
_CONTROL_PLUGINS = ("ros2_control", "ROS2Control")
"""Texts in the file name or name of Gazebo plugins that run a controller manager."""
_FIND = "$(find "
_MOST = 1e6
"""Maximum absolute value of a numeric parameter; a parameter with a larger value counts as missing."""


@dataclass(frozen=True, slots=True)
class Controller:
    """A ros2_control controller with its parameters.

    Attributes:
        name: name of the controller's node.
        type: plugin type, such as `diff_drive_controller/DiffDriveController`.
        span: source location of the controller's section.
        values: a dict from dotted names to the parameters of the controller.
    """

    name: str
    type: str
    span: Span
    values: dict[str, Value]

    @property
    def kind(self) -> str:
        """Type of the controller without its package."""
        return self.type.rpartition("/")[2]

    @property
    def title(self) -> str:
        """Type and name of the controller, for messages."""
        return printable(f"{self.kind} {self.name}")

    def number(self, *names: str) -> float | None:
        """Return the first number among the values of these parameters; None without a number."""
        for name in names:
            value = self.values.get(name)
            if value is not None and type(value.data) in (int, float) and abs(value.data) <= _MOST:
                return float(value.data)
        return None

    def positive(self, *names: str) -> float | None:
        """Return the first number among the values of these parameters if it is positive, else None."""
        number = self.number(*names)
        return number if number is not None and number > 0 else None

    def texts(self, *names: str) -> tuple[str, ...]:
        """Return all texts in these parameters, in the given order; each parameter has a text or a list of texts."""
        found: list[str] = []
        for value in (self.values[name] for name in names if name in self.values):
            items = value.data if isinstance(value.data, list) else [value]
            found += [item.data for item in items if isinstance(item.data, str)]
        return tuple(found)

    def flag(self, name: str, default: bool) -> bool:
        """Return the value of a boolean parameter; `default` if the parameter is missing or has another type."""
        value = self.values.get(name)
        return value.data if value is not None and isinstance(value.data, bool) else default


def load_parameters(path: Path, findings: Findings, shown_as: str | None = None) -> Document | None:
    """Read a ROS 2 parameter file, in which a node such as `/**` may have several sections; return None after an error."""
    return load(path, findings, shown_as, merge_keys=True)


def controllers(draft: Draft) -> list[Controller]:
    """Return the controllers of the user's parameter file; without this file, of the files that Gazebo plugins name."""
    documents = [draft.controllers] if draft.controllers is not None else list(_named(draft))
    return [controller for document in documents for controller in read(document)]


def read(document: Document) -> list[Controller]:
    """Return the controllers of a parameter file, in order of the file."""
    sections = list(_sections(document.root, ""))
    general: dict[str, Value] = {}
    for name, section in sections:
        if not name:  # /**: for every node
            general |= _flat(section)
    types = {
        key.removesuffix(".type"): value
        for _, section in sections
        for key, value in _flat(section).items()
        if key.endswith(".type") and isinstance(value.data, str)
    }
    found: list[Controller] = []
    for name, section in sections:
        values = general | _flat(section)
        told = values.get("type") or types.get(name)
        if name and told is not None and isinstance(told.data, str):
            found.append(Controller(name, told.data, section.span, values))
    return found


def _sections(value: Value, name: str) -> Iterator[tuple[str, Value]]:
    """Yield the node name and the parameters of each section; the name is empty if the section applies to all nodes."""
    if not isinstance(value.data, dict):
        return
    for key, item in value.data.items():
        if key == _PARAMETERS:
            yield name, item
        elif isinstance(item.data, dict):
            last = str(key).rstrip("/").rpartition("/")[2].strip("*")
            if isinstance((item.data.get("type") or item).data, str) and _PARAMETERS not in item.data:
                yield last, item  # as in ROS 1
            yield from _sections(item, last)


def _flat(value: Value) -> dict[str, Value]:
    """Return a dict from dotted names to the scalars and lists in nested mappings."""
    found: dict[str, Value] = {}
    pending = [("", value)]
    while pending:
        prefix, item = pending.pop()
        if not isinstance(item.data, dict):
            found[prefix] = item
            continue
        pending += [(f"{prefix}.{key}" if prefix else str(key), part) for key, part in reversed(item.data.items())]
    return found


def _named(draft: Draft) -> Iterator[Document]:
    """Yield the parameter files that ros2_control plugins of Gazebo name, each once."""
    seen: set[str] = set()
    for plugin in (element for element in draft.description.element.walk() if element.tag == "plugin"):
        name = plugin.get("filename") + plugin.get("name")
        if not any(part in name for part in _CONTROL_PLUGINS):
            continue
        draft.use(plugin)
        for parameters in plugin.all("parameters"):
            if parameters.text and parameters.text not in seen:
                seen.add(parameters.text)
                document = _open(draft, parameters.text, parameters.span)
                if document is not None:
                    yield document


def _open(draft: Draft, reference: str, span: Span) -> Document | None:
    """Return the parameter file to which a plugin refers; add the reason to `draft.lost` and return None after an error."""
    packages = draft.description.packages
    told = f"the controllers of {printable(reference)}"
    path = next(iter(packages.places(reference)), packages.folder / reference)
    if reference.startswith(_FIND):
        package, _, rest = reference.removeprefix(_FIND).partition(")")
        folder = packages.find(package.strip())
        if folder is None:
            draft.lose(f"{told}: {packages.lacks(package.strip())[0]}", span)
            return None
        path = folder / rest.lstrip("/")
    if not packages.files.may_read(path):
        draft.lose(f"{told}: name the file with --controllers FILE", span)
        return None
    findings = Findings()
    packages.files.note(path)
    document = load_parameters(path, findings, str(packages.files.shown(path)))
    for finding in findings.items:
        draft.lose(f"{told}: {finding.message}", finding.span or span)
    return document if not findings.errors else None
