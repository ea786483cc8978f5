"""`graphrun import-robot` and `graphrun new` make robots of SDF models, in the layouts that these have in Gazebo."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from tests.bringup.robots.imported_bases import DIFFERENTIAL, PLUGIN, sdf
from tests.cli.harness import Graphrun
from tests.cli.test_import_urdf import TETRAHEDRON

LID = """<sdf version="1.8"><model name="lid"><link name="lid">
<inertial><mass>.1</mass><inertia><ixx>.001</ixx><iyy>.001</iyy><izz>.001</izz></inertia></inertial>
<visual name="v"><geometry><mesh><uri>meshes/lid.obj</uri><scale>.1 .1 .1</scale></mesh></geometry></visual>
</link></model></sdf>"""
MOUNT = """<include><uri>model://lid</uri><pose relative_to="base_link">0 0 .1 0 0 0</pose></include>
<joint name="lid_joint" type="fixed"><parent>base_link</parent><child>lid::lid</child></joint></model></sdf>"""
TWO = sdf(DIFFERENTIAL).replace('<model name="diff">', '<world name="w"><model name="diff">').removesuffix("</sdf>")
TURNING = '<joint name="j" type="revolute"><parent>l</parent><child>m</child></joint>'
TWO += f'<model name="other"><link name="l"/><link name="m"/>{TURNING}</model></world></sdf>'


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to stand in, with two models side by side, of which one includes the other."""
    for name, text in (("cart", sdf(DIFFERENTIAL, PLUGIN).replace("</model></sdf>", MOUNT)), ("lid", LID)):
        folder = tmp_path / "models" / name
        (folder / "meshes").mkdir(parents=True)
        (folder / "model.sdf").write_text(text, encoding="utf-8")
        (folder / "model.config").write_text('<model><sdf version="1.8">model.sdf</sdf></model>', encoding="utf-8")
    (tmp_path / "models/lid/meshes/lid.obj").write_text(TETRAHEDRON, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


CART = "models/cart/model.sdf"


def test_a_model_becomes_a_robot_file_with_a_urdf(graphrun: Graphrun, models: Path) -> None:
    result = graphrun("import-urdf", CART, "-o", "cart.yaml", code=0, err="")
    assert result.lines[:2] == ["wrote cart.urdf, cart.yaml", "6 links, 5 joints of which 2 move, 5.6 kg"]
    assert "from Gazebo's plugin DiffDrive (model.sdf:" in result.out
    robot = yaml.safe_load((models / "cart.yaml").read_text(encoding="utf-8"))
    assert robot["urdf"] == "cart.urdf"
    assert robot["graphs"]["base"]["use"] == "graphs/base/differential.yaml"
    (models / "scene.yaml").write_text(
        "scene: s\nworld: worlds/flat_grid.xml\nrobots:\n  cart: {use: cart.yaml, position: [0, 0, 0.1]}\n"
    )
    graphrun("check", "scene.yaml", code=0)


def test_a_project_holds_the_meshes_of_included_models(graphrun: Graphrun, models: Path) -> None:
    graphrun("new", "made", "--from", CART, code=0)
    assert (models / "made/robots/lid/meshes/lid.obj").is_file()
    (models / "models/lid/meshes/lid.obj").unlink()
    graphrun("run", "made/made.yaml", "--transport", "memory", "--for", "0.1s", code=0)


def test_one_model_of_a_world_can_be_chosen(graphrun: Graphrun, models: Path) -> None:
    (models / "world.sdf").write_text(TWO, encoding="utf-8")
    refused = graphrun("import-urdf", "world.sdf", "-o", "cart.yaml", code=1)
    assert "the file has more than one model" in refused.err
    assert "--model NAME" in refused.err
    graphrun("import-urdf", "world.sdf", "--model", "diff", "-o", "cart.yaml", code=0)
    assert "no model 'dif'" in graphrun("import-urdf", "world.sdf", "--model", "dif", "-o", "a.yaml", code=1).err


def test_mistakes_name_the_place_in_the_sdf_and_write_nothing(graphrun: Graphrun, models: Path) -> None:
    text = (models / CART).read_text(encoding="utf-8")
    (models / CART).write_text(text.replace('type="revolute"', 'type="screw"', 1), encoding="utf-8")
    refused = graphrun("import-urdf", CART, "-o", "cart.yaml", code=1)
    assert "models/cart/model.sdf:4:" in refused.err
    assert "type 'screw' is not supported" in refused.err
    assert not (models / "cart.yaml").exists()


def test_models_elsewhere_need_a_package_path(graphrun: Graphrun, models: Path) -> None:
    (models / "models/lid").rename(models / "lid")
    (models / "models/cart").rename(models / "models/elsewhere")
    given = ("import-robot", "models/elsewhere/model.sdf", "-o", "cart.yaml")
    assert "model://lid" in graphrun(*given, code=1).err
    graphrun(*given, "--package-path", "lid", code=0)


def test_an_option_for_sdf_is_refused_for_other_descriptions(graphrun: Graphrun, models: Path) -> None:
    (models / "a.urdf").write_text('<robot name="a"><link name="base_link"/></robot>', encoding="utf-8")
    refused = graphrun("import-urdf", "a.urdf", "--model", "x", "-o", "a.yaml")
    assert (refused.code, "--model x: only SDF files contain several models, and a.urdf is not SDF" in refused.err) == (
        2,
        True,
    )
    assert "does not use xacro" in graphrun("import-urdf", CART, "a:=1", "-o", "a.yaml").err


def test_sdf_may_use_xacro(graphrun: Graphrun, models: Path) -> None:
    text = sdf(DIFFERENTIAL).replace("<sdf ", '<sdf xmlns:xacro="http://www.ros.org/wiki/xacro" ')
    text = text.replace("<radius>0.05</radius>", "<radius>${0.1 / 2}</radius>")
    (models / "cart.sdf.xacro").write_text(text, encoding="utf-8")
    graphrun("import-urdf", "cart.sdf.xacro", "-o", "cart.yaml", code=0)
    assert 'cylinder radius="0.05"' in (models / "cart.urdf").read_text(encoding="utf-8")
