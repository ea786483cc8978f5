"""Union types for ports of data nodes, after OmniGraph's groups of types.

A literal without an explicit type gets the first type of the group that accepts it. Integers therefore come first, since they
widen by themselves; lists of two to four numbers are tuples; matrices come last, since files give their type.
"""

from __future__ import annotations

from graphengine.node.types import ROLES


def arrays_of(union: str) -> str:
    """The array types of the given types."""
    return "|".join(f"{element}[]" for element in union.split("|"))


def with_arrays(union: str) -> str:
    """The given types and their array types."""
    return f"{union}|{arrays_of(union)}"


def tuples(*bases: str) -> str:
    """Tuples of two to four of the given types."""
    return "|".join(f"{base}[{count}]" for base in bases for count in (2, 3, 4))


def with_roles(letters: str) -> str:
    """Tuple types with roles, for the real bases d, f and h."""
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
"""Numbers and tuples of them, no matrices."""
NUMERICS = f"{PLAIN_NUMERICS}|{with_arrays(f'{MATRICES}|{FRAMES}')}"
BOOLEANS = "bool|bool[]"
VECTORS = with_arrays("vectord[3]|vectorf[3]|vectorh[3]")
QUATERNIONS = with_arrays("quatd[4]|quatf[4]|quath[4]")


def matrices(*sizes: int) -> str:
    """Types of square matrices and of arrays of them."""
    return with_arrays("|".join(f"matrixd[{size}]" for size in sizes))
