"""Union types for ports of data nodes, modeled on OmniGraph's groups of types.

A literal without an explicit type gets the first type of the union that accepts the literal. Integer types come first: an integer
literal becomes an integer; wires convert it to a real number if necessary. A list of two to four numbers becomes a tuple.
Matrix types come last, so a graph file must give the type of a matrix.
"""

from __future__ import annotations

from graphengine.node.types import ROLES


def arrays_of(union: str) -> str:
    """Return the union of the types `T[]` for all types `T` in a union."""
    return "|".join(f"{element}[]" for element in union.split("|"))


def with_arrays(union: str) -> str:
    """Return a union extended by the type `T[]` for each of its types `T`."""
    return f"{union}|{arrays_of(union)}"


def tuples(*bases: str) -> str:
    """Return the union of the tuple types `T[2]`, `T[3]` and `T[4]` for all base types `T` in `bases`."""
    return "|".join(f"{base}[{count}]" for base in bases for count in (2, 3, 4))


def with_roles(letters: str) -> str:
    """Return the union of all tuple types with a role; `letters` selects the base types (dfh: double, float, half)."""
    return "|".join(f"{role}{bits}[{count}]" for role, counts in ROLES.items() for count in counts for bits in letters)


INTEGRAL_SCALARS = "int|int64|uint64|uint|uchar"
REALS = "double|float|half"
DECIMAL_SCALARS = f"{REALS}|timecode"
REAL_TUPLES = tuples("double", "float", "half")
DECIMAL_TUPLES = f"{REAL_TUPLES}|{with_roles('dfh')}"
INTEGRAL_TUPLES = tuples("int")
MATRICES = "matrixd[2]|matrixd[3]|matrixd[4]"
FRAMES = "frame[4]|transform[4]"

DECIMALS = with_arrays(f"{DECIMAL_SCALARS}|{DECIMAL_TUPLES}")
PLAIN_NUMERICS = with_arrays(f"{INTEGRAL_SCALARS}|{DECIMAL_SCALARS}|{INTEGRAL_TUPLES}|{DECIMAL_TUPLES}")
"""Union of numbers, tuples, and arrays of both, without matrices."""
NUMERICS = f"{PLAIN_NUMERICS}|{with_arrays(f'{MATRICES}|{FRAMES}')}"
BOOLEANS = "bool|bool[]"
VECTORS = with_arrays("vectord[3]|vectorf[3]|vectorh[3]")
QUATERNIONS = with_arrays("quatd[4]|quatf[4]|quath[4]")


def matrices(*sizes: int) -> str:
    """Return the union of the matrix types with the given numbers of rows, and of their array types."""
    return with_arrays("|".join(f"matrixd[{size}]" for size in sizes))
