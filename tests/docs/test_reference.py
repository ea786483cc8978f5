"""The generated pages are those that the command writes, and have every type, verb, key and public name."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

import graphengine as ge
from graphengine import bringup
from graphengine.cli import VERBS
from graphengine.compiler.registry import default_registry
from graphengine.control.simulation_interfaces.server import _LEFT_OUT, SimulationInterfaces
from graphengine.format.spec_reader import KINDS
from graphengine.scene import build
from tests.cli.harness import ROOT
from tests.docs.generate import python_api
from tests.docs.generate.all_pages import REFERENCE, pages
from tests.docs.generate.examples import checked, example_of
from tests.docs.generate.limits import meaning_of
from tests.docs.generate.nodes import types_by_family
from tests.limits.exempt import TESTED
from tests.limits.table import LIMITS

FAMILIES = types_by_family()


def page(name: str) -> str:
    return (REFERENCE / name).read_text(encoding="utf-8")


def test_the_pages_are_up_to_date() -> None:
    made = dict(pages())
    kept = {path for path in (REFERENCE / "nodes").rglob("*.*") if path.is_file()}
    assert kept - made.keys() == set(), "python -m tests.docs.generate"
    differ = [path.name for path, text in made.items() if not path.is_file() or path.read_bytes() != text.encode()]
    assert differ == [], "python -m tests.docs.generate"


def test_every_node_type_has_a_section_a_drawing_and_an_example() -> None:
    types = {cls.type_name for cls in default_registry().types.values()}
    assert {cls.type_name for family in FAMILIES.values() for cls in family} == types
    for family, members in FAMILIES.items():
        text = page(f"nodes/{family}.md")
        for cls in members:
            assert f"](pictures/{cls.type_name}.svg)" in text
            assert f"`{cls.type_name}`, {cls.kind()}" in text
            assert f"```yaml\n{example_of(cls)}```" in text


@pytest.mark.parametrize("family", FAMILIES)
def test_the_examples_have_no_mistake(family: str, tmp_path: Path) -> None:
    for cls in FAMILIES[family]:
        assert cls.type_name in [instance.cls.type_name for instance in checked(example_of(cls), tmp_path).instances]


def test_every_verb_has_a_section() -> None:
    assert re.findall(r"^## (.+)$", page("verbs.md"), re.MULTILINE) == ["Exit codes", *VERBS, "test"]


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_of_a_file_has_its_meaning(kind: str) -> None:
    rows = dict(re.findall(r"^\| `(\w+)` \|.*\| (.*) \|$", page(f"{kind}_file.md"), re.MULTILINE))
    assert set(KINDS[kind].model_fields) <= set(rows)
    assert [key for key, meaning in rows.items() if not meaning.strip()] == []


def test_every_public_name_and_method_is_on_the_page_of_the_python_api() -> None:
    heads = set(re.findall(r"^#{3,4} (.+)$", page("python_api.md"), re.MULTILINE))
    assert {name for name in ge.__all__ if not name.startswith("_")} - {"gym"} <= heads
    assert {*bringup.__all__, *ge.gym.__all__} <= heads
    methods = {name for name, member in vars(ge.Session).items() if not name.startswith("_") and callable(member)}
    assert {f"Session.{name}" for name in methods} <= heads
    assert [name for name in python_api.public_names("graphengine") if not inspect.getdoc(getattr(ge, name))] == []


def test_every_limit_has_a_row_and_a_meaning() -> None:
    names = {*TESTED, *(one.name for one in LIMITS)}
    assert [name for name in names if f"| `{name}` |" not in page("limits.md")] == []
    assert [name for name in sorted(names) if not meaning_of(name)] == [], "write a docstring below the constant"


def test_every_service_of_simulation_interfaces_is_on_the_page_of_ros_interfaces() -> None:
    source = inspect.getsource(SimulationInterfaces._services)
    names = [*re.findall(r'^ +"(\w+)": \(', source, re.MULTILINE), *_LEFT_OUT]
    assert len(names) > 20
    assert [name for name in names if f"`/{name}`" not in page("ros_interfaces.md")] == []


def test_the_speed_ratio_in_the_table_of_differences_is_the_one_that_check_prints() -> None:
    assert "with 0.1 m for wheels of 0.049 m, as in the tutorial, the robot drives at 49 %" in page("differences.md")
    findings = build.load(ROOT / "scenes/tutorial/navigation.yaml").findings
    assert any("the robot will drive at 0.49 times the commanded speed" in one.help for one in findings.warnings)
