"""Robots that a xacro file defines as a macro: which one is taken, and the file that calls it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element, parse
from graphengine.descriptions.xacro.xacro_macros import choose_macro, has_robot, robot_macros, wrapper
from graphengine.format.diagnostics import Findings, Source, Span
from graphengine.format.files import Files

SPAN = Span(Source("rover.xacro", ()), 1, 1)
HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro">'
ROVER = '<xacro:macro name="rover" params="{}"><link name="base_link"/></xacro:macro>'


def root(inside: str) -> Element:
    element = parse(f"{HEAD}{inside}</robot>".encode(), "rover.xacro", Findings(), "S103")
    assert element is not None
    return element


@pytest.mark.parametrize(
    ("written", "parameters", "blocks"),
    [
        ("", {}, []),
        ("side radius:=0.1 kind:='a b'", {"side": None, "radius": "0.1", "kind": "'a b'"}, []),
        ("a=1  b:=^  c:=^|2", {"a": "1", "b": "^", "c": "^|2"}, []),
        ("parent *origin **content", {"parent": None}, ["origin", "content"]),
        ("*a/&gt;&lt;b", {}, ["block"]),
    ],
)
def test_parameters_of_a_macro_are_read_with_their_defaults(
    written: str, parameters: dict[str, str | None], blocks: list[str]
) -> None:
    (macro,) = robot_macros(root(ROVER.format(written)))
    assert macro.parameters == parameters
    assert macro.blocks == blocks


def test_a_macro_without_links_is_no_robot() -> None:
    assert robot_macros(root('<xacro:macro name="m"><material name="blue"/></xacro:macro>')) == []


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        (ROVER, False),
        (f"{ROVER}<xacro:rover/>", True),
        (f"{ROVER}<xacro:if value='1'><xacro:rover/></xacro:if>", True),
        (f"{ROVER}<link name='base'/>", True),
        (f"<xacro:arg name='a' default='1'/>{ROVER}", False),
    ],
)
def test_a_file_with_links_or_macro_calls_outside_macros_has_a_robot(inside: str, expected: bool) -> None:
    assert has_robot(root(inside)) is expected


def test_the_only_macro_of_a_file_without_a_robot_is_taken() -> None:
    findings = Findings()
    macro = choose_macro(root(ROVER.format("")), None, (), findings)
    assert macro is not None
    assert macro.name == "rover"
    assert choose_macro(root(f"{ROVER.format('')}<xacro:rover/>"), None, (), findings) is None
    assert findings.items == []


def test_one_of_several_macros_must_be_chosen() -> None:
    findings = Findings()
    two = ROVER.format("") + ROVER.format("").replace("rover", "truck")
    assert choose_macro(root(two), None, (), findings) is None
    assert findings.errors[0].help == ("choose: --macro rover, --macro truck",)
    macro = choose_macro(root(two), "truck", (), Findings())
    assert macro is not None
    assert macro.name == "truck"


@pytest.mark.parametrize(
    ("wanted", "parameters", "told"),
    [
        ("rovr", "", ("no macro 'rovr'", "did you mean 'rover'?")),
        ("rover", "side radius:=1", ("needs a value of 'side'", "add to the command: side:=…")),
    ],
)
def test_a_macro_that_cannot_be_called_is_explained(wanted: str, parameters: str, told: tuple[str, str]) -> None:
    findings = Findings()
    choose_macro(root(ROVER.format(parameters)), wanted, (), findings)
    (error,) = findings.errors
    assert told[0] in error.message
    assert told[1] in error.help


def test_the_wrapper_includes_the_file_by_its_package_and_has_all_given_values(tmp_path: Path) -> None:
    (tmp_path / "rovers/urdf").mkdir(parents=True)
    (tmp_path / "rovers/package.xml").write_text("<package><name>rovers</name></package>", encoding="utf-8")
    path = tmp_path / "rovers/urdf/rover.xacro"
    packages = Packages(path.parent, (), Files((tmp_path.resolve(),)))
    (macro,) = robot_macros(root(ROVER.format("wheel:='big' side *origin")))
    text = wrapper(macro, path, "mine", {"side": "${1}<", "simulated": "true"}, packages, complete=True)
    assert text.splitlines()[2:] == [
        '<robot name="mine" xmlns:xacro="http://www.ros.org/wiki/xacro">',
        '  <xacro:arg name="simulated" default="true"/>',
        '  <xacro:include filename="$(find rovers)/urdf/rover.xacro"/>',
        "  <!-- defaults: wheel:='big' -->",
        '  <xacro:rover side="$${1}&lt;">',
        '    <origin xyz="0 0 0" rpy="0 0 0"/>',
        "  </xacro:rover>",
        "</robot>",
    ]


def test_a_comment_of_the_wrapper_stays_a_comment(tmp_path: Path) -> None:
    (macro,) = robot_macros(root(ROVER.format("a:='--&gt;&lt;mesh/&gt;--'")))
    text = wrapper(macro, tmp_path / "r.xacro", "r", {}, Packages(tmp_path, (), Files((tmp_path,))), complete=True)
    found = parse(text.encode(), "r", Findings(), "S103")
    assert found is not None
    assert [child.tag for child in found.children] == ["xacro:include", "xacro:rover"]


TEXTS = st.text(st.characters(exclude_categories=["Cs", "Cc"]) | st.sampled_from("<>&\"'${}-* :=^|"), max_size=30)


@given(params=TEXTS, arguments=st.dictionaries(TEXTS, TEXTS, max_size=3))
def test_for_any_file_and_arguments_the_wrapper_is_xml_that_calls_the_macro(
    params: str, arguments: dict[str, str]
) -> None:
    element = Element("xacro:macro", {"name": "rover", "params": params}, SPAN, [Element("link", {}, SPAN)])
    (macro,) = robot_macros(Element("robot", {}, SPAN, [element]))
    path, packages = Path("/nowhere/rover.xacro"), Packages(Path("/nowhere"), (), Files((Path("/nowhere"),)))
    # The names of parameters come from a file of XML, in which the user's attributes would be refused by the parser.
    others = {key: value for key, value in arguments.items() if key not in macro.parameters}
    text = wrapper(macro, path, "rover", others, packages, complete=True)
    found = parse(text.encode(), "rover", Findings(), "S103")
    assert found is not None
    tags = [child.tag for child in found.children]
    assert tags == ["xacro:arg"] * len(others) + ["xacro:include", "xacro:rover"]
    assert [child.get("name") for child in found.children[: len(others)]] == list(others)
