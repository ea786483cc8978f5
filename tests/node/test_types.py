"""Port types: names, literals, and which wire carries what how."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.node import types
from graphengine.node.types import CONVERTERS, POINTER, PortType, UnionType, coerce, conversion, parse


def concrete(name: str) -> PortType:
    found = parse(name)
    assert isinstance(found, PortType)
    return found


NAMES = [
    *("bool", "uchar", "int", "uint", "int64", "uint64", "half", "float", "double", "timecode"),
    *("token", "string", "path", "objectId", "target", "execution", "any", "bundle"),
    *("double[2]", "double[3]", "double[4]", "float[3]", "int[2]", "half[4]"),
    *("double[]", "int[]", "bool[]", "token[]", "string[]", "uchar[]", "double[3][]", "float[4][]"),
    *("vectord[3]", "vectorf[3][]", "pointd[3]", "normalf[3]", "colord[4]", "colorf[3]", "texcoordh[2]", "quatd[4]"),
    *("matrixd[2]", "matrixd[3]", "matrixd[4]", "frame[4]", "transform[4]", "quatf[4][]"),
]


@pytest.mark.parametrize("name", NAMES)
def test_every_name_of_a_type_is_read_and_written_alike(name: str) -> None:
    assert str(concrete(name)) == name


NO_NAMES = (
    "Double double[1] double[10] double[3 vectord vectord[4] quatd[3] matrixd[5] matrixf[4] vectori[3] double[][]"
)


@pytest.mark.parametrize("name", ["", *NO_NAMES.split(), "any[3]", "target[2]", "number", "double|real"])
def test_a_name_that_is_no_type_is_refused(name: str) -> None:
    with pytest.raises(ValueError, match="is not a port type"):
        parse(name)


def test_a_union_lists_its_alternatives() -> None:
    union = parse("float|double | vectord[3]")
    assert isinstance(union, UnionType)
    assert [str(one) for one in union.alternatives] == ["float", "double", "vectord[3]"]
    assert str(union) == "float | double | vectord[3]"


ZEROS = {"bool": False, "int": 0, "double": 0.0, "token": "", "target": (), "any": None, "token[]": ()}
ZEROS |= {"double[2]": (0.0, 0.0), "int[3]": (0, 0, 0), "vectord[3]": (0.0, 0.0, 0.0)}
ZEROS |= {"quatd[4]": (0.0, 0.0, 0.0, 1.0), "matrixd[2]": (1.0, 0.0, 0.0, 1.0)}


@pytest.mark.parametrize("name", ZEROS)
def test_a_type_has_a_zero(name: str) -> None:
    assert concrete(name).zero == ZEROS[name]


@pytest.mark.parametrize(("name", "shape"), [("double[]", (0,)), ("double[3][]", (0, 3)), ("bool[]", (0,))])
def test_the_zero_of_an_array_type_is_an_empty_read_only_array_of_its_dtype(name: str, shape: tuple[int, ...]) -> None:
    zero = concrete(name).zero
    assert (zero.shape, zero.dtype) == (shape, concrete(name).dtype)
    assert not zero.flags.writeable


# Literals


@pytest.mark.parametrize(
    ("name", "given", "expected"),
    [
        ("double", 1, 1.0),
        ("double", np.float32(0.5), 0.5),
        ("int", 5, 5),
        ("uint64", 2**64 - 1, 2**64 - 1),
        ("bool", True, True),
        ("token", "x", "x"),
        ("vectord[3]", [1, 2, 3], (1.0, 2.0, 3.0)),
        ("double[2]", np.array([1.0, 2.0]), (1.0, 2.0)),
        ("target", "/dd100", ("/dd100",)),
        ("target", ["/a", "", "/b"], ("/a", "/b")),
        ("target", "", ()),
        ("token[]", ["a", "b"], ("a", "b")),
        ("any", {"x": 1}, {"x": 1}),
    ],
)
def test_a_literal_takes_the_one_representation_of_its_type(name: str, given: object, expected: object) -> None:
    value = coerce(given, concrete(name))
    assert value == expected
    assert type(value) is type(expected)


@pytest.mark.parametrize(
    ("name", "given", "error"),
    [
        *(("double", given, TypeError) for given in ("1", True, None)),
        *(("int", given, TypeError) for given in (1.0, True)),
        *(("bool", given, TypeError) for given in (1, "no")),
        *(("vectord[3]", given, TypeError) for given in ("xyz", 1.0)),
        *(("double[]", given, TypeError) for given in (1.0, "12", [[1.0]])),
        *(("target", given, TypeError) for given in (5, ["/a", 5])),
        *[("token", 5, TypeError), ("string", True, TypeError), ("token[]", "abc", TypeError)],
        *[
            ("int", 2**31, ValueError),
            ("uchar", -1, ValueError),
            ("uchar", 256, ValueError),
            ("uint64", -1, ValueError),
        ],
        *[("vectord[3]", [1, 2], ValueError), ("double[3][]", [[1.0, 2.0]], ValueError)],
        ("float[]", [3.5e38], ValueError),
        ("half[]", [70_000.0], ValueError),
        ("colorf[3][]", [[0.0, 0.0, -3.5e38]], ValueError),
    ],
)
def test_a_literal_of_another_type_is_refused(name: str, given: object, error: type[Exception]) -> None:
    with pytest.raises(error, match="expected"):
        coerce(given, concrete(name))


@pytest.mark.parametrize(
    ("name", "given", "dtype", "shape"),
    [
        ("double[]", [1, 2], np.float64, (2,)),
        ("float[]", [], np.float32, (0,)),
        ("int[]", [1, -1], np.int32, (2,)),
        ("uint64[]", [2**64 - 1], np.uint64, (1,)),
        ("bool[]", [True], np.bool_, (1,)),
        ("double[3][]", [[1, 2, 3], [4, 5, 6]], np.float64, (2, 3)),
        ("double[3][]", [], np.float64, (0, 3)),
        ("quatd[4][]", np.eye(4), np.float64, (4, 4)),
    ],
)
def test_an_array_literal_has_the_exact_dtype_and_shape_and_cannot_be_written(
    name: str, given: object, dtype: type, shape: tuple[int, ...]
) -> None:
    value = coerce(given, concrete(name))
    assert (value.dtype, value.shape) == (dtype, shape)
    with pytest.raises(ValueError, match="read-only"):
        value[...] = 0


def test_a_matrix_may_be_written_row_by_row() -> None:
    rows = [[1, 2, 3], [4, 5, 6], [7, 8, 9]]
    assert coerce(rows, concrete("matrixd[3]")) == tuple(float(n) for n in range(1, 10))
    assert coerce([rows, rows], concrete("matrixd[3][]")).tolist() == [list(range(1, 10))] * 2


@pytest.mark.parametrize(
    ("rows", "error"),
    [([[1, 2], [3, 4, 5]], ValueError), ([[1, 2], 3], TypeError), (["ab", "cd"], TypeError), ([1, 2, 3], ValueError)],
)
def test_rows_that_make_no_matrix_are_refused(rows: object, error: type[Exception]) -> None:
    with pytest.raises(error, match="expected"):
        coerce(rows, concrete("matrixd[2]"))


NUMBERS = [concrete(name) for name in NAMES if concrete(name).is_number]


@given(st.sampled_from(NUMBERS), st.data())
def test_a_coerced_value_is_coerced_to_itself(port_type: PortType, data: st.DataObject) -> None:
    quarters: st.SearchStrategy[float] = st.integers(-1000, 1000).map(lambda n: n / 4)
    scalars: dict[str, st.SearchStrategy[Any]] = {"bool": st.booleans(), "uchar": st.integers(0, 255)}
    scalars |= dict.fromkeys(("half", "float", "double", "timecode"), quarters)
    scalar = scalars.get(port_type.base, st.integers(0, 2**31 - 1))
    element = scalar if port_type.count == 1 else st.lists(scalar, min_size=port_type.count, max_size=port_type.count)
    value = coerce(data.draw(st.lists(element, max_size=3) if port_type.array else element), port_type)
    assert types.equal(coerce(value, port_type), value)


# Wires


SCALARS = ["bool", "uchar", "int", "uint", "int64", "uint64", "half", "float", "double", "token", "string"]
ALLOWED = {
    ("bool", "int64"): "int64",
    ("bool", "double"): "double",
    **{(base, "int64"): "" for base in ("uchar", "int", "uint")},
    **{(base, "double"): "double" for base in ("uchar", "int", "uint", "int64", "uint64")},
    **{(base, "double"): "" for base in ("half", "float")},
}


@pytest.mark.parametrize("target", SCALARS)
@pytest.mark.parametrize("source", SCALARS)
def test_scalar_types_are_converted_as_the_table_states(source: str, target: str) -> None:
    expected = "" if source == target else ALLOWED.get((source, target))
    assert conversion(concrete(source), concrete(target)) == expected


@pytest.mark.parametrize(
    ("source", "target", "converter"),
    [
        ("vectord[3]", "double[3]", ""),
        ("colord[3]", "pointd[3]", ""),
        ("int[3]", "double[3]", "double_tuple"),
        ("float[3]", "vectord[3]", ""),
        ("bool[2]", "int64[2]", "int64_tuple"),
        ("int[]", "int64[]", "int64_array"),
        ("bool[]", "int64[]", "int64_array"),
        ("float[]", "double[]", "double_array"),
        ("int[3][]", "double[3][]", "double_array"),
        ("double[]", "float[]", None),
        ("double[3]", "double[4]", None),
        ("double[3]", "double[]", None),
        ("double", "double[]", None),
        ("token[]", "token[]", ""),
        ("double", "timecode", ""),
        ("float", "timecode", ""),
        ("timecode[]", "double[]", ""),
        ("timecode", "float", None),
        ("target", "token", None),
        ("double[3][]", "any", ""),
        ("token", "any", ""),
        ("any", "double", None),
    ],
)
def test_tuples_and_arrays_are_converted_like_scalars_and_any_takes_every_type(
    source: str, target: str, converter: str | None
) -> None:
    assert conversion(concrete(source), concrete(target)) == converter


EXAMPLES: dict[str, Any] = {"bool": True, "int": -3, "float": 0.5, "int[3]": (1, 2, 3), "bool[2]": (True, False)}
EXAMPLES |= {"int[]": np.array([1, 2], np.int32), "float[]": np.array([0.5], np.float32)}
EXAMPLES |= {"bool[]": np.array([True, False])}


@pytest.mark.parametrize("target", ["int64", "double"])
@pytest.mark.parametrize("source", EXAMPLES)
def test_a_converted_value_is_in_the_representation_of_the_target(source: str, target: str) -> None:
    one = concrete(source)
    other = PortType(target, one.count, one.array)
    name = conversion(one, other)
    if name is None:
        return
    value = CONVERTERS[name](EXAMPLES[source]) if name else EXAMPLES[source]
    assert types.equal(coerce(value, other), value)
    if one.array:
        assert value.dtype == other.dtype
    else:
        first = value[0] if one.count > 1 else value
        assert type(first) is (int if target == "int64" else float)


@pytest.mark.parametrize("port_type", ["double", "double[2]", "double[]", "float[3][]"])
def test_nan_equals_nan(port_type: str) -> None:
    kind = concrete(port_type)
    element: Any = float("nan") if kind.count == 1 else [float("nan")] + [1.0] * (kind.count - 1)
    one, other = (coerce([element] if kind.array else element, kind) for _ in range(2))
    assert types.equal(one, other)
    assert not types.equal(one, coerce([], kind) if kind.array else kind.zero)


def test_equal_compares_arrays_whole() -> None:
    assert types.equal(np.zeros(3), np.zeros(3))
    assert not types.equal(np.zeros(3), np.zeros(2))
    assert not types.equal(np.zeros(1), 0.0)
    assert types.equal((1.0, 2.0), (1.0, 2.0))
    assert not types.equal("a", "b")


def test_a_pointer_is_a_uint64_and_is_0_by_default() -> None:
    assert (str(POINTER), POINTER.zero) == ("uint64", 0)


@pytest.mark.parametrize("buffer", [b"abc", bytearray(3), memoryview(b"abc"), np.zeros((2, 3), np.float32)])
def test_a_pointer_carries_the_buffer_itself(buffer: Any) -> None:
    assert coerce(buffer, POINTER) is buffer


@pytest.mark.parametrize("address", [1, 2**40, -1, 0.0, True, False, "0", None, [1, 2]])
def test_an_address_is_no_buffer(address: Any) -> None:
    with pytest.raises(TypeError, match="only a wire can provide a buffer"):
        coerce(address, POINTER)


def test_a_pointer_can_be_wired_to_a_pointer_but_not_to_a_number() -> None:
    assert conversion(POINTER, POINTER) == conversion(POINTER, types.ANY) == ""
    assert conversion(POINTER, concrete("double")) is conversion(POINTER, concrete("int64")) is None
