"""Descriptions of keys: docstrings below the fields of specs, inherited and explicit ones."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
from pydantic import Field

from graphengine.format.key_docs import key_docs
from graphengine.format.spec import FileSpec


class Wheel(FileSpec):
    """A wheel."""

    radius: float = 0.0
    """Radius of the wheel, m.

    The default is no radius.
    """
    width: float = Field(default=0.0, description="Width of the wheel, m.")
    colour: str = ""


class Tyre(Wheel):
    """A wheel with a tyre, which has a wider radius."""

    radius: float = 0.0
    """Radius with the tyre, m."""
    pressure: float = 0.0
    """Pressure of the tyre, Pa."""


class Roller(Wheel):
    """A wheel of which two keys mean something else."""

    radius: float = Field(default=0.0, description="Radius of the roller, m.")
    """Docstring that the description replaces."""
    width: float = 0.0


def test_keys_have_the_docstrings_below_their_fields_and_the_descriptions_of_fields() -> None:
    assert key_docs(Wheel) == {
        "radius": "Radius of the wheel, m.\n\nThe default is no radius.",
        "width": "Width of the wheel, m.",
    }


def test_a_derived_spec_keeps_inherited_docs_and_replaces_them_by_its_own() -> None:
    assert key_docs(Tyre) == {
        "radius": "Radius with the tyre, m.",
        "width": "Width of the wheel, m.",
        "pressure": "Pressure of the tyre, Pa.",
    }
    assert key_docs(Roller) == {"radius": "Radius of the roller, m."}


def test_the_schema_shows_the_docs() -> None:
    properties = Tyre.model_json_schema()["properties"]
    assert {key: value.get("description") for key, value in properties.items()} == {
        "radius": "Radius with the tyre, m.",
        "width": "Width of the wheel, m.",
        "colour": None,
        "pressure": "Pressure of the tyre, Pa.",
    }


def test_a_spec_without_a_source_file_has_no_docs(monkeypatch: pytest.MonkeyPatch) -> None:
    module = ModuleType("typed_in")
    monkeypatch.setitem(sys.modules, "typed_in", module)
    exec("from graphengine.format.spec import FileSpec\nclass Typed(FileSpec):\n    size: int = 0\n", vars(module))
    assert key_docs(module.Typed) == {}
    monkeypatch.delitem(sys.modules, "typed_in")
    assert key_docs(type("Typed", (module.Typed,), {"__module__": "typed_in_too"})) == {}


def test_a_module_that_no_longer_parses_has_no_docs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "half_saved.py"
    source.write_text(
        'from graphengine.format.spec import FileSpec\nclass Saved(FileSpec):\n    size: int = 0\n    """m"""\n'
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    saved = import_module("half_saved")
    source.write_text("class Saved(\n")
    assert key_docs(saved.Saved) == {}
