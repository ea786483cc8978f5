"""What `${…}` of a xacro file may be, and what it may not."""

from __future__ import annotations

import builtins
import math
from typing import Any

import pytest

from graphengine.descriptions.xacro.xacro_expressions import evaluate
from graphengine.sandbox.expressions import ForbiddenError

NAMES = "abs dict enumerate float hash int isinstance len list map max min range repr reversed round set sorted str sum tuple zip"


def names() -> dict[str, Any]:
    wheel = {"radius": 0.3, "sizes": [1, 2, 3]}
    return {name: getattr(builtins, name) for name in NAMES.split()} | {"pi": math.pi, "wheel": wheel, "side": "left"}


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("2 * pi * wheel.radius", 2 * math.pi * 0.3),
        (" -1 if side == 'left' and not 3 in wheel['sizes'][:2] else 1 ", -1),
        ("{k: v for k, v in zip('ab', wheel.sizes)}.items()", {"a": 1, "b": 2}.items()),
        ("max(wheel.sizes, key=lambda size: -size)", 1),
        ("'front,rear'.split(',')[1].upper()", "REAR"),
        ("f'{side}_{wheel.radius:.2f}'", "left_0.30"),
        ("'%s_wheel' % side", "left_wheel"),
        ("wheel.get('width', 1)", 1),
        ("[sizes.append(4) for sizes in [[*wheel.sizes]]]", [None]),
        ("len([[[0] * 99] * 99] * 99 + list(range(2000000)))", 2000099),
    ],
)
def test_an_expression_has_the_value_that_python_gives_it(expression: str, value: object) -> None:
    assert evaluate(expression, names()) == value


@pytest.mark.parametrize(
    "expression",
    [
        "().__class__.__base__.__subclasses__()",
        "(lambda: 0).__globals__",
        "(lambda: ().__class__)()",
        "'{0.__class__}'.format(0)",
        "'{x}'.format_map(wheel)",
        "len.__self__",
        "wheel.items.__self__",
        "wheel.sizes.__len__()",
        "(lambda __builtins__: 0)(1)",
        "[0 for wheel.radius in [1]]",
        "'a'.encode().hex()",
        "0 .to_bytes(2, 'big')",
    ],
)
def test_no_expression_reaches_the_internals_of_python(expression: str) -> None:
    with pytest.raises((ForbiddenError, SyntaxError)):
        evaluate(expression, names())


def test_an_unknown_name_is_reported_as_in_python() -> None:
    with pytest.raises(NameError, match="'open' is not defined"):
        evaluate("open('/etc/passwd')", names())
    with pytest.raises(NameError, match="the namespace or mapping has no entry 'width'"):
        evaluate("wheel.width", names())
