"""What a guarded expression computes, and what it cannot do."""

from __future__ import annotations

import ast
import re
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.sandbox.expressions import (
    FUNCTIONS,
    MAX_BITS,
    MAX_CHARACTERS,
    MAX_DEPTH,
    MAX_STEPS,
    ForbiddenError,
    Guard,
    compiled,
)

NAMES: dict[str, Any] = {"i": 7, "x": -2.5, "text": "left,right", "some": [3, 1, 2], "table": {"a": 1, "b": [2.0]}}


def evaluate(expression: str, known: bool = True) -> Any:
    names = {**FUNCTIONS, **NAMES}
    return Guard().evaluate(compiled(expression, known=[*names] if known else None), names)


# What it computes

NUMBERS = st.integers(-20, 20).map(str) | st.floats(-9, 9).map(repr) | st.sampled_from(["i", "x", "some[0]", "True"])
LEAVES = NUMBERS | st.sampled_from(["text", "'a b'", "some", "table", "table['b']", "(1, 2)", "{1, 2}", "None"])
BINARY = re.split(", ", "+, -, *, /, //, %, &, |, ^, ==, !=, <, <=, >, >=, in, not in, and, or")
UNARY = re.findall(r"\w+", "abs all any bool len list max min sorted str sum tuple")


def combined(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    binary = st.sampled_from(BINARY)
    return st.one_of(
        st.builds("({} {} {})".format, inner, binary, inner),
        st.builds("({} < {} <= {})".format, inner, inner, inner),
        st.builds("({}{})".format, st.sampled_from(["-", "+", "~", "not "]), inner),
        st.builds("({} ** {})".format, inner, st.sampled_from("0123")),
        st.builds("({} << {})".format, inner, st.sampled_from("0123")),
        st.builds("({} if {} else {})".format, inner, inner, inner),
        st.builds("{}({})".format, st.sampled_from(UNARY), inner),
        st.builds("[{}, *{}]".format, inner, inner),
        st.builds("{{'a': {}, **{}}}".format, inner, inner),
        st.builds("{}[{}]".format, inner, inner),
        st.builds("{}[1:{}]".format, inner, inner),
        st.builds("[{} for y in {} if y]".format, inner | st.just("y"), inner),
        st.builds("any({} for y in {})".format, inner | st.just("y < 2"), inner),
        st.builds("f'{{{}!r:>9}}_{{{}}}'".format, st.sampled_from(["i", "x", "text"]), st.sampled_from(["i", "some"])),
        st.builds("({}).{}".format, inner, st.sampled_from(["upper()", "split(',')", "index(1)", "get('a')", "real"])),
    )


@given(st.recursive(LEAVES, combined, max_leaves=8))
def test_an_expression_has_the_same_value_or_error_as_in_python(expression: str) -> None:
    found: list[Any] = []
    for evaluated in (evaluate, lambda text: eval(text, {**FUNCTIONS, **NAMES})):
        try:
            with warnings.catch_warnings(action="ignore"):  # Python's, of what is likely a mistake
                found.append(repr(evaluated(expression)))
        except ForbiddenError as error:
            if "attribute" not in str(error):
                return  # a limit, which Python has not
            found.append(AttributeError)  # which this type does not have
        except Exception as error:
            found.append(type(error))
    guarded, python = found
    assert guarded == python


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("{k: v for k, v in zip('ab', some)}", {"a": 3, "b": 1}),
        ("[(a, b) for a in some for b in some if a < b]", [(1, 3), (1, 2), (2, 3)]),
        ("{*some, *'ab'}", {1, 2, 3, "a", "b"}),
        ("max(some, default=i)", 3),
        ("'%5.1f|%s 20000 * 2' % (x, text)", " -2.5|left,right 20000 * 2"),
        ("f'{x:{i}.2f}'", "  -2.50"),
        ("hypot(3, 4) > 2 * pi", False),
        ("table.get('c', [])", []),
        ("some is not None and table.get('c') is None", True),
        (" 1 ", 1),
    ],
)
def test_typical_expressions_of_users_are_evaluated(expression: str, value: object) -> None:
    assert evaluate(expression) == value


# What it cannot do


@pytest.mark.parametrize(
    "expression",
    [
        "().__class__.__base__.__subclasses__()",
        "__builtins__",
        "__import__('os')",
        "abs.__self__",
        "len.__call__([])",
        "str.format('{0.__class__}', 0)",
        "'{0.__class__}'.format(0)",
        "'{a.__class__}'.format_map(table)",
        "f'{().__class__}'",
        "f'{1:{().__class__}}'",
        "(y for y in some).gi_frame",
        "[y for y in some if y.__class__]",
        "{**table}.__class__",
        "[*some].__class__",
        "str(*some.__class__)",
        "dict(__class__=1)",
        "some.append(4)",
        "[0 for some[0] in some if some.clear]",
        "[0 for table.a in some]",
        "(y := 1)",
        "lambda: 0",
        "(yield 1)",
        "[await y for y in some]",
        "open('/etc/passwd')",
        "range(10)",
        "sorted(some, key=some.index)",
        "nothing",
    ],
)
def test_no_expression_reaches_the_internals_of_python(expression: str) -> None:
    with pytest.raises((ForbiddenError, SyntaxError)):
        evaluate(expression)


@pytest.mark.parametrize(
    ("expression", "limit"),
    [
        ("9 ** 9 ** 9", MAX_BITS),
        ("1 << 10 ** 12", MAX_BITS),
        ("True << 99999", MAX_BITS),
        (" * ".join(["9 ** 3000"] * 5), MAX_BITS),
        ("'ab' * 10 ** 9", MAX_STEPS),
        ("10 ** 9 * [0]", MAX_STEPS),
        ("[[0] * 9000 for y in 'a' * 9000]", MAX_STEPS),
        ("[some[:] for y in 'a' * 90000 for z in 'a' * 90000]", MAX_STEPS),
        ("[0 for a in 'a' * 9999 for b in 'a' * 9999]", MAX_STEPS),
        ("all(a for a in [1] * 9999 for b in [1] * 9999)", MAX_STEPS),
        ("[f'{a}{a}' for a in ['a' * 90000] * 90000]", MAX_STEPS),
        ("[[*a, *a] for a in [[0] * 90000] * 90000]", MAX_STEPS),
        (f"str({'[' * 40}0{'] * 9' * 40})", MAX_STEPS),
        ("{" + "(" * 40 + "0," + ") * 9" * 40 + "}", MAX_STEPS),
        ("[a == b for a in [[0] * 90000] for b in [[0] * 90000] for c in a for d in a]", MAX_STEPS),
        ("[a.count(1) for a in [[0] * 90000] for b in a]", MAX_STEPS),
        ("[f(1) for a in [[0] * 90000] for f in [a.count] for b in a]", MAX_STEPS),
        ("[{*a} - {*a} for a in [[0] * 90000] for b in a]", MAX_STEPS),
        ("f'{[2 ** 4999] * 90000}'", MAX_STEPS),
        ("'%1000000000d' % 1", 999),
        ("'%(a(b)c)1000000000d' % {'a(b)c': 1}", 999),
        ("'%5.1000000000f' % 1", 999),
        ("'%*d' % (10 ** 9, 1)", 999),
        ("'%(a)-1000000000d' % table", 999),
        ("b'%1000000000d' % 1", 999),
        ("f'{1:1000000000}'", 999),
        ("f'{1:{10 ** 9}}'", 999),
        ("f'{x:.1000000000f}'", 999),
        ("-" * 50_000 + "1", MAX_DEPTH),
        ("some" + "[0]" * 20_000, MAX_DEPTH),
        ("+".join("1" * 20_000), MAX_DEPTH),
        ("[" * 150 + "]" * 150, MAX_DEPTH),
        ("1 or " * MAX_CHARACTERS, MAX_CHARACTERS),
    ],
)
def test_an_expression_that_exceeds_a_limit_is_refused_at_once(expression: str, limit: int) -> None:
    with pytest.raises(ForbiddenError, match=rf"\b{limit}\b"):
        evaluate(expression)


def test_an_expression_of_almost_the_greatest_depth_is_evaluated() -> None:
    assert evaluate("+".join("1" * (MAX_DEPTH - 5))) == MAX_DEPTH - 5


def test_deeply_nested_brackets_are_refused() -> None:
    with pytest.raises((ForbiddenError, SyntaxError)):
        evaluate("(" * 40_000 + ")" * 40_000)


def test_the_step_limit_of_a_guard_holds_for_all_its_evaluations_together() -> None:
    guard, code, a_tenth = Guard(), compiled("a + a"), [0] * (MAX_STEPS // 10)
    for _ in range(2):
        assert guard.evaluate(code, {"a": a_tenth}) == 2 * a_tenth
    with pytest.raises(ForbiddenError, match=rf"\b{MAX_STEPS}\b"):
        guard.evaluate(code, {"a": a_tenth})


def test_a_list_times_an_overflowing_numpy_integer_is_refused() -> None:
    with pytest.raises(ForbiddenError, match=rf"\b{MAX_STEPS}\b"):
        Guard().evaluate(compiled("[0, 1, 2, 3] * times"), {"times": np.int64(2**62)})


def test_elements_of_numpy_arrays_count_as_fewer_steps() -> None:
    names = {**FUNCTIONS, "image": np.zeros(MAX_STEPS), "times": [0] * 90}
    assert Guard().evaluate(compiled("[len(image + 1) for t in times[:9]]"), names) == [MAX_STEPS] * 9
    with pytest.raises(ForbiddenError, match=rf"\b{MAX_STEPS}\b"):
        Guard().evaluate(compiled("[image + 1 for t in times]"), names)


def test_an_unknown_name_is_refused_at_compilation_with_similar_names() -> None:
    with pytest.raises(ForbiddenError, match=r"there is no name 'maxx'\ndid you mean 'max'"):
        compiled("some or maxx(some)", known=["some", "max"])
    with pytest.raises(NameError, match="'maxx' is not defined"):
        evaluate("maxx(some)", known=False)


def test_a_tree_can_be_compiled_twice_and_names_of_python_can_be_given() -> None:
    tree = ast.parse("[__name__, some[0] + 1]", mode="eval").body
    names = {"__name__": "main", "some": [1]}
    assert [Guard().evaluate(compiled(tree, known=names), names) for _ in range(2)] == [["main", 2]] * 2
    with pytest.raises(ForbiddenError, match="'__builtins__' is not allowed"):
        compiled("__builtins__", known=names)  # which are among the names by now
    with pytest.raises(ForbiddenError, match="'__name__' is not allowed"):
        compiled("some.__name__", known=names)


def test_a_forbidden_attribute_is_an_error_that_lists_the_allowed_attributes() -> None:
    told = r"'reverse' of a list is not allowed in an expression\nlegal: count, index"
    with pytest.raises(ForbiddenError, match=told):
        evaluate("some.reverse()")
    with pytest.raises(ForbiddenError, match=r"Lambda is not allowed in an expression\nlegal: values, names"):
        evaluate("lambda: 0")
