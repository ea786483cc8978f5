"""xacro: what it expands to, where its mistakes are told, and what a stranger's file cannot do."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from graphengine.descriptions.files.packages import Packages
from graphengine.descriptions.files.xml import Element
from graphengine.descriptions.urdf.urdf_reader import read_urdf
from graphengine.descriptions.xacro import xacro
from graphengine.format.diagnostics import Findings, to_json
from graphengine.format.files import Files
from graphengine.sandbox import confinement
from tests.descriptions.files.forging import forged
from tests.other_process import in_another_process
from tests.physics.harness import Project, load

HEAD = '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="cart">\n'
BODY = """  <link name="base_link">
    <inertial><mass value="5"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
"""
WHEEL = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:macro name="wheel" params="side reflect radius">
    <link name="${side}_wheel">
      <inertial><mass value="1"/><inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><sphere radius="${radius}"/></geometry></collision>
    </link>
    <joint name="${side}_wheel_joint" type="continuous">
      <parent link="base_link"/><child link="${side}_wheel"/>
      <origin xyz="0 ${reflect * size.track / 2} 0"/><axis xyz="0 1 0"/>
    </joint>
  </xacro:macro>
</robot>
"""
CART = f"""{HEAD}{BODY}  <xacro:arg name="radius" default="0.1"/>
  <xacro:arg name="camera" default="false"/>
  <xacro:property name="size" value="${{xacro.load_yaml('size.yaml')}}"/>
  <xacro:include filename="wheel.xacro"/>
  <xacro:wheel side="left" reflect="1" radius="$(arg radius)"/>
  <xacro:wheel side="right" reflect="-1" radius="$(arg radius)"/>
  <xacro:if value="$(arg camera)"><link name="camera"/>
    <joint name="camera_joint" type="fixed"><parent link="base_link"/><child link="camera"/></joint>
  </xacro:if>
</robot>
"""


@pytest.fixture
def cart(project: Project) -> Project:
    project.write("bot.urdf.xacro", CART).write("wheel.xacro", WHEEL).write("size.yaml", "track: 0.5\n")
    return project.write("bot.yaml", "robot: bot\nurdf: bot.urdf.xacro\n")


def description(project: Project, inside: str) -> Project:
    """A robot whose description holds nothing but a body and what is given."""
    project.write("bot.yaml", "robot: bot\nurdf: bot.xacro\n")
    return project.write("bot.xacro", f"{HEAD}{BODY}{inside}\n</robot>\n")


def test_arguments_includes_macros_conditions_and_yaml_are_expanded(cart: Project) -> None:
    world = cart.load()
    robot = world.robots["bot"]
    assert list(robot.description.links) == ["base_link", "left_wheel", "right_wheel"]
    assert robot.wheel_radii == {"left_wheel_joint": 0.1, "right_wheel_joint": 0.1}
    assert [joint.pose[0] for joint in robot.moving] == [(0, 0.25, 0), (0, -0.25, 0)]
    assert "xacro" not in robot.urdf_text
    cart.write("bot.yaml", "robot: bot\nurdf: bot.urdf.xacro\nxacro_arguments: {radius: 0.2, camera: true}\n")
    robot = cart.load().robots["bot"]
    assert list(robot.description.links)[-1] == "camera"
    assert robot.wheel_radii["left_wheel_joint"] == 0.2


def test_the_files_that_were_read_are_noted(cart: Project) -> None:
    packages = Packages(cart.folder, (), Files((cart.folder.resolve(),)))
    assert xacro.expand(cart.folder / "bot.urdf.xacro", {}, packages, Findings()) is not None
    assert [path.name for path in packages.files.used] == ["bot.urdf.xacro", "wheel.xacro", "size.yaml"]


def test_a_mistake_in_the_output_of_a_macro_is_reported_at_its_source_line(cart: Project) -> None:
    first, second = cart.write("wheel.xacro", WHEEL.replace('parent link="base_link"', 'parent link="base"')).errors()
    assert "wheel.xacro:8:21: error S103: joint 'left_wheel_joint': no parent link 'base'" in first
    assert "did you mean 'base_link'?" in first
    assert "joint 'right_wheel_joint'" in second


def test_a_file_that_needs_xacro_is_expanded_under_any_name(cart: Project) -> None:
    cart.write("bot.urdf", CART).robot("xacro_arguments: {radius: 0.3}")
    assert cart.load().robots["bot"].wheel_radii["left_wheel_joint"] == 0.3


def text_of(scene: Path) -> str:
    return load(scene).robots["bot"].urdf_text


def test_the_expansion_does_not_depend_on_the_hash_seed(cart: Project) -> None:
    letters = "${' '.join(python.list(python.set(['a', 'b', 'c', 'd', 'e', 'f', 'g', 'h'])))}"
    description(cart, f"<gazebo><letters>{letters}</letters></gazebo>")
    scene = cart.folder / "scene.yaml"
    assert in_another_process(text_of, scene) == text_of(scene)


@pytest.mark.parametrize(
    ("inside", "told"),
    [
        ('<link name="${nme}"/>', "bot.xacro:5:1: error S103: xacro: name 'nme' is not defined"),
        ('<link name="$(arg nme)"/>', "xacro: the argument 'nme' has no value"),
        ('<link name="$(arg nme)"/>', "write xacro_arguments: {nme: …} in the robot file"),
        ("<xacro:wheel/>", "bot.xacro:5:1: error S103: xacro: unknown macro name: xacro:wheel"),
        ('<xacro:include filename="part.xacro"/>', "bot.xacro:5:1: error S103: xacro: no file '"),
        ('<xacro:property name="p" value="${xacro.load_yaml(\'p.yaml\')}"/><link name="${p}"/>', "No such file"),
        ('<xacro:include filename="broken.xacro"/>', "broken.xacro:2:3: error S103: XML syntax: mismatched tag"),
        ('<xacro:if value="perhaps"><link/></xacro:if>', 'conditional "perhaps" evaluated to "perhaps"'),
        ("<link/>", "bot.xacro:5:1: error S103: a link without a name"),
    ],
)
def test_a_mistake_in_xacro_is_reported_at_its_place(project: Project, inside: str, told: str) -> None:
    project.write("broken.xacro", "<robot>\n</x>\n")
    assert told in description(project, inside).error()


def test_a_mistake_in_a_macro_names_its_caller(cart: Project) -> None:
    error = cart.write("size.yaml", "trak: 0.5\n").error()
    assert "wheel.xacro:9:7: error S103: xacro: the namespace or mapping has no entry 'track'" in error
    assert "bot.urdf.xacro:9:3: called here" in error


def test_an_unknown_argument_is_reported(cart: Project) -> None:
    error = cart.write("bot.yaml", "robot: bot\nurdf: bot.urdf.xacro\nxacro_arguments: {radus: 0.2}\n").error()
    assert "bot.yaml:3:19: error G111: " in error
    assert "has no argument 'radus'" in error
    assert "did you mean 'radius'?" in error


def test_arguments_for_a_file_without_xacro_are_refused(project: Project) -> None:
    project.robot("xacro_arguments: {radius: 1}")
    assert "bot.yaml:3:1: error G109: xacro_arguments: 'bot.urdf' does not use xacro" in project.error()


def test_an_optional_include_may_be_missing_but_not_outside_the_folder(project: Project) -> None:
    assert description(project, '<xacro:include filename="part.xacro" optional="true"/>').load()
    description(project, '<xacro:include filename="/etc/passwd" optional="true"/>')
    assert "'/etc/passwd' lies outside the folder of the file you gave" in project.error()


@pytest.fixture
def outside(project: Project) -> Path:
    """A folder with a secret, beside the one that may be read, and a link to it inside."""
    folder = project.folder.parent / f"{project.folder.name}_outside"
    folder.mkdir()
    (folder / "secret.xacro").write_text('<robot><link name="secret"/></robot>', encoding="utf-8")
    (folder / "secret.yaml").write_text("key: secret\n", encoding="utf-8")
    (project.folder / "link.xacro").symlink_to(folder / "secret.xacro")
    (project.folder / "folder").symlink_to(folder)
    return folder


@pytest.mark.parametrize(
    "inside",
    [
        '<xacro:include filename="{outside}/secret.xacro"/>',
        '<xacro:include filename="../{outside.name}/secret.xacro"/>',
        '<xacro:include filename="{outside}/*.xacro"/>',
        '<xacro:include filename="folder/s*.xacro"/>',
        '<xacro:include filename="link.xacro"/>',
        '<xacro:include filename="$(find {outside.name})/secret.xacro"/>',
        "<link name=\"${{xacro.load_yaml('{outside}/secret.yaml')['key']}}\"/>",
        "<link name=\"${{load_yaml('folder/secret.yaml').key}}\"/>",
        "<link name=\"${{xacro.load_yaml(xacro.abs_filename('{outside}/secret.yaml')).key}}\"/>",
    ],
)
def test_xacro_reads_nothing_outside_its_folder(project: Project, outside: Path, inside: str) -> None:
    error = description(project, inside.format(outside=outside)).error()
    assert "lies outside the folder of the file you gave" in error
    assert "allow it with --allow" in error


@pytest.mark.parametrize(
    "inside",
    [
        "<link name=\"${__import__('os').system('touch marker')}\"/>",
        "<link name=\"${[c for c in ().__class__.__base__.__subclasses__() if c.__name__ == 'Popen'][0]('ls')}\"/>",
        '<link name="${(lambda: ().__class__)()}"/>',
        "<link name=\"${xacro.load_yaml.__globals__['os'].system('touch marker')}\"/>",
        "<link name=\"${'{0.__globals__}'.format(load_yaml)}\"/>",
        '<link name="${python.vars(xacro)}"/>',
        "<link name=\"${python.type('X', (), {})}\"/>",
        '<link name="$(eval [].append.__self__)"/>',
        '<link name="$(eval sin.cos)"/>',
        '<xacro:property name="__builtins__" value="${{\'open\': 1}}"/>',
        '<xacro:property name="n" value="!!python/object/apply:os.system [touch marker]"/><link name="${evil.x}"/>',
        '<xacro:property name="evil" value="${load_yaml(\'evil.yaml\')}"/><link name="${evil}"/>',
    ],
)
def test_xacro_runs_no_code(project: Project, inside: str) -> None:
    project.write("evil.yaml", "!!python/object/apply:os.system ['touch marker']\n")
    assert "error S103: xacro: " in description(project, inside).error()
    assert not list(project.folder.rglob("marker"))
    assert not Path("marker").exists()


DOUBLED = "".join(f'<xacro:property name="p{n + 1}" value="${{p{n}}}${{p{n}}}" lazy_eval="false"/>' for n in range(12))
"""Properties, each twice as long as the one before."""


@pytest.mark.parametrize(
    ("inside", "told"),
    [
        ('<link name="$(env HOME)"/>', "$(env HOME): environment variables are not read"),
        ('<xacro:include filename="entities.xacro"/>', "a document type is not allowed"),
        ('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>', "xacro: the file expands without end"),
        ('<xacro:property name="a" value="${a}"/><link name="${a}"/>', "circular variable definition"),
        ('<link name="$(eval wheels)"/>', "xacro: name 'wheels' is not defined"),
        (
            f"<xacro:property name='p0' value=\"${{'a' * 900000}}\"/>{DOUBLED}",
            "xacro: the expansion takes more than 1024 MiB",
        ),
        ("<link name=\"${'a' * 10 ** 10}\"/>", "xacro: an expression may take at most 1000000 steps"),
        ('<link name="${xacro.fatal(7)}"/>', "xacro: 7"),
        ("<link name=\"${xacro.load_yaml(b'/etc/passwd')}\"/>", "xacro: open is not allowed here"),
        (
            "<link name=\"${'\\ud800'}\"/>",
            "bot.xacro:5:1: error S103: xacro: '\\ud800' contains characters that XML forbids",
        ),
        ("<gazebo>${'\\x00'}</gazebo>", "xacro: '\\x00' contains characters that XML forbids"),
    ],
)
def test_xacro_gets_no_dangerous_arguments_or_files(project: Project, inside: str, told: str) -> None:
    project.write("entities.xacro", '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>\n<robot>&a;</robot>')
    assert told in description(project, inside).error()


@pytest.mark.parametrize(
    ("inside", "name"),
    [
        ('<xacro:element xacro:name="{}"/>', "a/&gt;&lt;mesh filename='/etc/passwd'"),
        ('<origin><xacro:attribute name="{}" value="1"/></origin>', "a='1'/&gt;&lt;mesh filename='/etc/passwd' b"),
    ],
)
def test_generated_names_cannot_smuggle_in_elements(project: Project, inside: str, name: str) -> None:
    """MuJoCo would open the file that such an element names."""
    error = description(project, f"<gazebo>{inside.format(name)}</gazebo>").error()
    assert "is not a valid XML name" in error


def test_eval_knows_the_arguments_as_numbers(project: Project) -> None:
    inside = '<xacro:arg name="wheels" default="4"/><gazebo><count>$(eval wheels * 2)</count></gazebo>'
    text = description(project, inside).load().robots["bot"].urdf_text
    assert "<count>8</count>" in text


def test_an_environment_variable_with_a_default_has_that_value(project: Project) -> None:
    text = description(project, "<gazebo><name>$(optenv HOME nobody)</name></gazebo>").load().robots["bot"].urdf_text
    assert "<name>nobody</name>" in text


def test_xacro_that_takes_too_long_is_ended(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xacro, "MAX_SECONDS", 0.5)
    twice = '<xacro:m n="${n - 1}"/>' * 2
    inside = (
        f'<xacro:macro name="m" params="n"><xacro:if value="${{n}}">{twice}</xacro:if></xacro:macro><xacro:m n="40"/>'
    )
    assert "xacro: the process that expands the file takes more than 0.5 s" in description(project, inside).error()


def workspace(folder: Path, **packages: str) -> Path:
    """The `share` of a workspace built with `--symlink-install`: packages of one xacro file each."""
    for name, text in packages.items():
        (folder / "share" / name).mkdir(parents=True)
        (folder / "src" / name).mkdir(parents=True)
        (folder / "src" / name / "part.xacro").write_text(text, encoding="utf-8")
        (folder / "share" / name / "part.xacro").symlink_to(folder / "src" / name / "part.xacro")
    return folder / "share"


INCLUDE = '<xacro:include filename="$(find {})/part.xacro"/>'


@pytest.mark.parametrize(
    ("top", "expected"),
    [
        (INCLUDE.format("wheels"), [["wheels"]]),
        (INCLUDE.format("bodies"), [["bodies"], ["bodies", "wheels"]]),
        ('<xacro:property name="p" value="wheels"/>' + INCLUDE.format("${p}"), [[], ["wheels"]]),
    ],
    ids=["named in the file", "named in one that it includes", "named by a property"],
)
def test_of_a_sourced_workspace_only_the_named_packages_can_be_read(
    top: str, expected: list[list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    share = workspace(tmp_path, wheels=WHEEL, bodies=f"{HEAD}{INCLUDE.format('wheels')}</robot>", other=WHEEL)
    (tmp_path / "mine").mkdir()
    path = tmp_path / "mine" / "bot.urdf.xacro"
    path.write_text(f"{HEAD}{BODY}{top}</robot>", encoding="utf-8")
    asked = []

    def ask(module: str, request: bytes, seconds: float) -> bytes:
        asked.append(json.loads(request))
        return confinement.ask(module, request, seconds)

    monkeypatch.setattr(xacro, "ask", ask)
    findings = Findings()
    files = Files.of(path, installed=[share])
    root = xacro.expand(path, {}, Packages(path.parent, (), files), findings)
    assert findings.items == []
    assert root is not None
    assert [sorted(Path(folder).name for folder in request["installed"]) for request in asked] == expected
    assert not any(str(share) in request["roots"] for request in asked)
    assert tmp_path / "share" / expected[-1][0] / "part.xacro" in files.used


def test_a_missing_package_is_reported_with_the_packages_found(tmp_path: Path) -> None:
    share = workspace(tmp_path, wheels=WHEEL)
    (share / "wheels" / "package.xml").write_text("<name>wheels</name>", encoding="utf-8")
    path = tmp_path / "bot.urdf.xacro"
    path.write_text(f"{HEAD}{BODY}{INCLUDE.format('wheel')}</robot>", encoding="utf-8")
    findings = Findings()
    assert xacro.expand(path, {}, Packages(path.parent, (), Files.of(path, installed=[share])), findings) is None
    (finding,) = findings.items
    assert finding.message == "xacro: no package 'wheel'"
    assert "did you mean 'wheels'?" in finding.help


EMPTY: dict[str, object] = {
    "wanted": None,
    "used": [],
    "findings": [],
    "elements": [],
    "known": {},
    "absent": [],
    "unknown_calls": [],
}
ELEMENT = {"tag": "robot", "attributes": {}, "span": ["BOT", 1, 1, 1], "children": [], "text": ""}
SPOILT: list[object] = [
    None,
    3,
    {},
    {"wanted": None},
    {**EMPTY, "used": [3]},
    {**EMPTY, "findings": [{}]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "span": ["/etc/passwd", 1, 1, 1]}]]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "span": ["n" * 300, 1, 1, 1]}]]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "span": ["\0", 1, 1, 1]}]]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "children": 3}]]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "children": [ELEMENT]}]]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "tag": "include file='/etc/passwd'/"}]]},
    {**EMPTY, "elements": [[1, {**ELEMENT, "attributes": {"a='1'/><mesh file='/etc/passwd' b": ""}}]]},
    *({**EMPTY, "elements": [[1, ELEMENT], [depth, ELEMENT]]} for depth in (-1, 0, 1, 3, "2")),
    {**EMPTY, "elements": [[depth, ELEMENT] for depth in range(1, 300)]},
]


@pytest.mark.parametrize("answer", [*map(json.dumps, SPOILT), "[" * 100_000, "no JSON"], ids=lambda text: text[:20])
def test_a_forged_answer_of_the_process_is_refused(answer: str, cart: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    (cart.folder / "loop").symlink_to("loop")
    monkeypatch.setattr(xacro, "ask", lambda *_: answer.replace("BOT", f"{cart.folder}/bot.urdf.xacro").encode())
    assert "xacro: the process that expands the file sends a malformed answer" in cart.error()


def test_no_forged_answer_raises_anything_but_errors_of_this_package(
    cart: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = []

    def ask(*given: Any) -> bytes:
        real.append(confinement.ask(*given))
        return real[-1]

    def expanded() -> Element | None:
        findings = Findings()
        packages = Packages(path.parent, (), Files.of(path))
        root = xacro.expand(path, {}, packages, findings)
        if root is not None:
            read_urdf(root, packages, findings)
        to_json(findings.sorted())
        assert root is not None or findings.errors
        assert all(finding.render() for finding in findings.items)
        return root

    path = cart.folder / "bot.urdf.xacro"
    monkeypatch.setattr(xacro, "ask", ask)
    (cart.folder / "loop").symlink_to("loop")
    assert expanded()
    monkeypatch.setattr(xacro, "MAX_SECONDS", 0.1)
    for answer in forged(real[0], 300):
        monkeypatch.setattr(xacro, "ask", lambda *_, answer=answer: answer)
        expanded()


def test_a_forged_answer_with_a_forbidden_file_is_refused(cart: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the file would be kept in recordings."""
    answer = {**EMPTY, "used": ["/etc/passwd", "loop", "\0", "n" * 300]}
    monkeypatch.setattr(xacro, "ask", lambda *_: json.dumps(answer).encode())
    path = cart.folder / "bot.urdf.xacro"
    files = Files.of(path)
    assert xacro.expand(path, {}, Packages(path.parent, (), files), Findings()) is None
    assert list(files.used) == [path]
