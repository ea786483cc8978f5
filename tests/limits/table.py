"""The table of limits: each named limit of the package, and how it is tried.

`named_limits` finds the limits by the names of constants. Each has an entry, in the file of this folder for its room:

    @limit("format.document.MAX_VALUES", at=100)
    def _(size: int, folder: Path) -> bool: ...

The function builds an input of a size, gives it to the package, and returns whether it was accepted whole. It is called with the
value of the limit, which must be accepted, and with the next larger one, which must not. `at` replaces the value of a large limit
during the test. A limit that has a test elsewhere is in `TESTED`, one that bounds no input in `BOUNDS_NO_INPUT`.
"""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
_NAME = (
    r"_?(MAX|MOST|LONGEST|LARGEST|FARTHEST|FASTEST|SLOWEST|STRONGEST|BRIGHTEST|SMALLEST|SHORTEST)(_[A-Z_0-9]+)?"
    r"|([A-Z_]+_)?(LIMIT|TIMEOUT|BOUND|BACKLOG|PATIENCE|SECONDS)"
)
"""Matches the names of constants that are limits."""
_NAMES = re.compile(rf"^ *({_NAME})\b.*=", re.MULTILINE)
Number = int | float


@dataclass(frozen=True)
class Limit:
    """A limit and how it is tried.

    Attributes:
        name: module, without the name of the package, and constant, such as `format.document.MAX_DEPTH`.
        accepts: returns whether an input of a size is accepted.
        at: value of the limit in the test; None: its own value.
        lower: whether the limit is the least legal value.
        step: difference between the limit and the size beyond it; None: 1, or the next floating point number.
    """

    name: str
    accepts: Callable[..., bool]
    at: Number | None
    lower: bool
    step: Number | None

    def try_it(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[bool, bool]:
        """Return whether an input at the limit is accepted, and whether one beyond it is."""
        value = self.at if self.at is not None else limit_value(self.name)
        if self.at is not None:
            _replace(self.name, self.at, monkeypatch)
        sign = -1 if self.lower else 1
        beyond: Number = math.nextafter(value, sign * math.inf)
        if self.step is not None or isinstance(value, int):
            beyond = value + sign * (self.step or 1)
        tries: list[bool] = []
        for size in (value, beyond):
            place = folder / f"{len(tries)}"
            place.mkdir()
            given = (size, place)[: len(inspect.signature(self.accepts).parameters)]
            tries.append(self.accepts(*given))
        return tries[0], tries[1]


LIMITS: list[Limit] = []


def limit(
    *names: str, at: Number | None = None, lower: bool = False, step: Number | None = None
) -> Callable[[Callable[..., bool]], Callable[..., bool]]:
    """Enter a function into the table that tries limits; it takes the size of an input, and a folder if it needs one."""

    def enter(accepts: Callable[..., bool]) -> Callable[..., bool]:
        LIMITS.extend(Limit(name, accepts, at, lower, step) for name in names)
        return accepts

    return enter


def named_limits() -> Iterator[str]:
    """Yield the names of all limits: constants of modules and classes with a number as value."""
    for module, text in _modules().items():
        if _NAMES.search(text):
            yield from (f"{module}.{name}" for name in _constants(ast.parse(text)))


@cache
def _modules() -> dict[str, str]:
    """Return the text of each module by its name without the name of the package."""
    texts = {}
    for top, prefix in ((ROOT / "graphengine", ""), (ROOT / "nodes", "nodes.")):
        for path in sorted(top.rglob("*.py")):
            module = ".".join(path.relative_to(top).with_suffix("").parts).removesuffix(".__init__")
            texts[prefix + module] = path.read_text(encoding="utf-8")
    return texts


def _constants(body: ast.Module | ast.ClassDef) -> Iterator[str]:
    for statement in body.body:
        if isinstance(statement, ast.ClassDef):
            yield from (f"{statement.name}.{name}" for name in _constants(statement))
        targets = statement.targets if isinstance(statement, ast.Assign) else []
        targets += [statement.target] if isinstance(statement, ast.AnnAssign) else []
        for target in targets:
            value = statement.value if isinstance(statement, ast.Assign | ast.AnnAssign) else None
            if (
                isinstance(target, ast.Name)
                and re.fullmatch(_NAME, target.id)
                and value is not None
                and _is_number(value)
            ):
                yield target.id


def _is_number(value: ast.expr) -> bool:
    """Return whether an expression is a number, or computed from numbers and other constants."""
    if isinstance(value, ast.BinOp):
        return _is_number(value.left) and _is_number(value.right)
    if isinstance(value, ast.Constant):
        return type(value.value) in (int, float)
    return isinstance(value, ast.Name) and value.id.isupper()


def _home(name: str) -> tuple[Any, str]:
    """Return the module or class that holds a constant, and the constant's own name."""
    path, _, constant = name.rpartition(".")
    owner, _, inner = path.rpartition(".")
    if inner[:1].isupper():
        return getattr(import_module(f"graphengine.{owner}"), inner), constant
    return import_module(f"graphengine.{path}"), constant


def limit_value(name: str) -> Any:
    """Return the value of a limit."""
    return getattr(*_home(name))


def _replace(name: str, value: Number, monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace a limit in its module, and in the modules that import it."""
    home, constant = _home(name)
    monkeypatch.setattr(home, constant, value)
    for module in _importers(home.__name__, constant) if inspect.ismodule(home) else ():
        monkeypatch.setattr(import_module(module), constant, value)


def _importers(home: str, constant: str) -> Iterator[str]:
    """Yield the names of the modules that import a constant by its name."""
    for module, text in _modules().items():
        if f"from {home} import" in text and any(
            isinstance(node, ast.ImportFrom)
            and node.module == home
            and constant in [alias.name for alias in node.names]
            for node in ast.walk(ast.parse(text))
        ):
            yield f"graphengine.{module}"


def accepts(action: Callable[[], object], *refusals: type[BaseException]) -> bool:
    """Return whether an action does not raise one of the given exceptions."""
    try:
        action()
    except refusals:
        return False
    return True


def repeat(times: int, action: Callable[[], object]) -> None:
    """Do something a number of times."""
    for _ in range(times):
        action()
