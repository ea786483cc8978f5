"""Inputs without which the data nodes cannot do, by the names of their classes."""

from __future__ import annotations

from typing import Any

import numpy as np

_IDENTITY = tuple(float(i % 5 == 0) for i in range(16))
_VECTOR = (1.0, -2.0, 2.0)
_QUATERNION = (0.5, 0.5, 0.5, 0.5)

_SHARED: dict[str, dict[str, Any]] = {
    "Add Subtract Multiply Divide ATan2 Compare": {"a": 6.0, "b": 4.0},
    "BooleanAnd BooleanOr BooleanNand BooleanNor": {"a": True, "b": False},
    "Sin Cos Tan Asin Acos Atan": {"value_in": 0.5},
    "Absolute Negate Round": {"input_in": -1.25},
    "Floor Ceil": {"a": 1.5},
    "NthRoot IsZero AnyZero EachZero Increment": {"value": 4.0},
    "CrossProduct DotProduct Distance3D": {"a": _VECTOR, "b": (0.0, 0.0, 1.0)},
    "Transpose InvertMatrix BreakMatrix4 GetMatrix4Translation GetMatrix4Scale": {"matrix": _IDENTITY},
    "GetMatrix4Quaternion GetMatrix4Rotation GetMatrix4RotationMatrix": {"matrix": _IDENTITY},
}

_ARRAY = np.array([1.0, 2.0, 1.0])

NEEDED: dict[str, dict[str, Any]] = {
    **{name: inputs for names, inputs in _SHARED.items() for name in names.split()},
    "AppendPath": {"path_in": "/robot", "suffix": "base_link"},
    "AppendTargets": {"input0": ("/a", "/b"), "input1": ("/b", "/c")},
    "ArrayReplaceValue": {"array_in": _ARRAY, "value": 1.0, "new_value": 3.0},
    "ArrayReverse": {"array_in": _ARRAY},
    "BooleanNot": {"value_in": True},
    "BreakMatrix2": {"matrix": (1.0, 0.0, 0.0, 1.0)},
    "BreakMatrix3": {"matrix": _IDENTITY[:9]},
    "BreakVector2": {"tuple_in": (1.0, 2.0)},
    "BreakVector3": {"tuple_in": (1.0, 2.0, 3.0)},
    "BreakVector4": {"tuple_in": (1.0, 2.0, 3.0, 4.0)},
    "CapitalizeString": {"string_in": "base link", "operation": "Title"},
    "Clamp": {"input_in": 3.0, "lower": 0.0, "upper": 2.0},
    "Ease": {"alpha": 0.25, "start": 0.0, "end": 4.0},
    "Exponent": {"base": 3.0},
    "FindString": {"string": "base_link", "value": "_"},
    "GetParentPath": {"path": "/robot/base_link"},
    "GetString": {"string_in": "base_link", "index": 5, "count": 2},
    "InsertString": {"string_in": "base", "value": "_link", "index": 4},
    "InterpolateTo": {"current": 0.0, "target": 4.0},
    "Logarithm": {"value": 100.0},
    "Magnitude": {"input_in": _VECTOR},
    "MakeMatrix2": {"x": (1.0, 2.0), "y": (3.0, 4.0)},
    "MakeMatrix3": {"x": _VECTOR, "y": _VECTOR, "z": _VECTOR},
    "MakeMatrix4": {"x": _VECTOR, "y": _VECTOR, "z": _VECTOR, "w": _VECTOR},
    "MakeVector2": {"x": 1.0, "y": 2.0},
    "MakeVector3": {"x": 1.0, "y": 2.0, "z": 3.0},
    "MakeVector4": {"x": 1.0, "y": 2.0, "z": 3.0, "w": 4.0},
    "MatrixMultiply": {"a": _IDENTITY, "b": _IDENTITY},
    "Modulo": {"a": 7, "b": 4},
    "Normalize": {"vector": _VECTOR},
    "RemoveString": {"string_in": "base_link", "index": -5},
    "ReplaceString": {"string_in": "base_link", "replace": "_", "value": "/"},
    "RotateVector": {"rotation": _QUATERNION, "vector": _VECTOR},
    "SetMatrix4Quaternion": {"matrix_in": _IDENTITY, "quaternion": _QUATERNION},
    "SetMatrix4Rotation": {"matrix_in": _IDENTITY, "rotation_angle": 90.0},
    "SetMatrix4Scale": {"matrix_in": _IDENTITY, "scale": _VECTOR},
    "SetMatrix4Translation": {"matrix_in": _IDENTITY, "translation": _VECTOR},
    "SplitString": {"string": "base link"},
    "ToDeg": {"radians": 1.0},
    "ToRad": {"degrees": 90.0},
    "TransformVector": {"matrix": _IDENTITY, "vector": _VECTOR},
}
