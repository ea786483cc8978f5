"""Includes: where models are found, how they are placed and named, and what is not read."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from graphengine.descriptions.sdf.sdf_files import model_folders
from tests.descriptions.sdf.harness import document, errors, joint, link, model, place, pose, scope, urdf

WHEEL = document(
    model(
        link("hub", pose(0, 0, 1)) + link("tyre") + joint("j", "hub", "tyre") + f'<frame name="f">{pose(1)}</frame>',
        "wheel",
    )
)


def write(folder: Path, name: str, text: str = WHEEL, file: str = "model.sdf", config: str = "") -> Path:
    """A model in a folder of its name."""
    (folder / name).mkdir(parents=True, exist_ok=True)
    (folder / name / file).write_text(text, encoding="utf-8")
    if config:
        (folder / name / "model.config").write_text(f"<model>{config}</model>", encoding="utf-8")
    return folder / name / file


def include(uri: str, content: str = "", more: str = "") -> str:
    return f"<include{more}><uri>{uri}</uri>{content}</include>"


def test_a_model_is_included_under_its_name_or_another(tmp_path: Path) -> None:
    write(tmp_path, "wheel")
    content = link("base") + include("model://wheel") + include("model://wheel", "<name>left</name>" + pose(0, 1))
    found, findings = scope(tmp_path, document(model(content)))
    assert not findings.items
    assert list(found.models) == ["wheel", "left"]
    assert place(found, "wheel::hub") == (0, 0, 1, 0, 0, 0)
    assert place(found, "left::hub") == (0, 1, 1, 0, 0, 0)
    assert place(found, "left::f") == (1, 1, 0, 0, 0, 0)


def test_an_included_model_is_placed_by_a_frame_of_it(tmp_path: Path) -> None:
    write(tmp_path, "wheel")
    placed = "<placement_frame>hub</placement_frame>" + pose(5, relative_to="base")
    found, _ = scope(tmp_path, document(model(link("base", pose(0, 2)) + include("model://wheel", placed))))
    assert place(found, "wheel::hub") == (5, 2, 0, 0, 0, 0)
    assert place(found, "wheel") == (5, 2, -1, 0, 0, 0)


def test_without_a_pose_in_the_include_the_model_keeps_its_pose(tmp_path: Path) -> None:
    write(tmp_path, "wheel", document(model(pose(7) + link("hub"), "wheel")))
    found, _ = scope(tmp_path, document(model(link("base") + include("model://wheel"))))
    assert place(found, "wheel::hub") == (7, 0, 0, 0, 0, 0)


def test_a_merged_model_gives_its_names_to_the_enclosing_model(tmp_path: Path) -> None:
    write(tmp_path, "wheel")
    content = link("base", pose(relative_to="hub")) + joint("axle", "base", "hub")
    text = document(model(content + include("model://wheel", pose(0, 3), ' merge="true"')))
    found, _ = scope(tmp_path, text)
    assert place(found, "base") == (0, 3, 1, 0, 0, 0)
    assert list(urdf(tmp_path, text).links) == ["base", "hub", "tyre"]
    assert list(urdf(tmp_path, text).joints) == ["axle", "j"]


def test_plugins_of_an_include_belong_to_the_model(tmp_path: Path) -> None:
    write(tmp_path, "wheel")
    plugin = '<plugin name="p" filename="f"><joint_name>j</joint_name></plugin>'
    mounted = document(model(link("base") + include("model://wheel", plugin) + joint("m", "base", "wheel::hub")))
    assert [part.text for part in urdf(tmp_path, mounted).element.walk() if part.tag == "joint_name"] == ["wheel::j"]


@pytest.mark.parametrize("uri", ["model://wheel", "package://wheel/model.sdf", "wheel", "wheel/model.sdf", "./wheel/model.sdf",
                                 "https://fuel.gazebosim.org/1.0/Somebody/models/wheel/3"])  # fmt: skip
def test_a_model_is_found_by_each_kind_of_uri(tmp_path: Path, uri: str) -> None:
    write(tmp_path, "wheel")
    found, findings = scope(tmp_path, document(model(link("base") + include(uri))))
    assert not findings.items
    assert list(found.models) == ["wheel"]


def test_a_model_is_found_in_models_around_the_file(tmp_path: Path) -> None:
    write(tmp_path / "models", "wheel")
    found, _ = scope(tmp_path, document(model(link("base") + include("model://wheel"))))
    assert list(found.models) == ["wheel"]


def test_of_several_versions_of_a_model_the_newest_supported_one_is_used(tmp_path: Path) -> None:
    named = [("1.6", "old"), ("1.9", "new"), ("1.99", "future")]
    config = "".join(f'<sdf version="{version}">{name}.sdf</sdf>' for version, name in named)
    for version, name in named:
        write(tmp_path, "wheel", document(model(link(name), "wheel"), version), f"{name}.sdf", config)
    found, _ = scope(tmp_path, document(model(link("base") + include("model://wheel"))))
    assert list(found.models["wheel"].links) == ["new"]


def test_meshes_of_an_included_model_lie_in_its_folder(tmp_path: Path) -> None:
    mesh = "<collision name='c'><geometry><mesh><uri>meshes/a.stl</uri></mesh></geometry></collision>"
    write(tmp_path, "wheel", document(model(link("hub", mesh), "wheel")))
    named = ("model://wheel", "model://wheel/model.sdf", "wheel", "wheel/model.sdf")
    places = ("model://wheel/meshes/a.stl", "model://wheel/meshes/a.stl", "wheel/meshes/a.stl", "wheel/meshes/a.stl")
    for uri, expected in zip(named, places, strict=True):
        text = document(model(link("base") + include(uri) + joint("j", "base", "wheel::hub")))
        meshes = [part.get("filename") for part in urdf(tmp_path, text).element.walk() if part.tag == "mesh"]
        assert meshes == [expected]
        assert any(
            path.parent == tmp_path / "wheel" / "meshes" for path in urdf(tmp_path, text).packages.places(expected)
        )


# What is not read


def test_a_missing_model_is_an_error_with_the_searched_folders(tmp_path: Path) -> None:
    text = document(model(link("base") + "\n" + include("model://wheel")))
    assert errors(tmp_path, text) == ["4: no model 'model://wheel'"]
    fuel = document(model(link("base") + include("https://fuel.gazebosim.org/1.0/x/models/Big%20Wheel")))
    assert "no model" in errors(tmp_path, fuel)[0]
    assert "no model" in errors(tmp_path, document(model(link("base") + include("ftp://a/b"))))[0]


@pytest.mark.parametrize("uri", ["model://outside", "../outside", "file://{outside}/model.sdf", "model://link"])
def test_nothing_outside_of_the_folder_is_read(tmp_path: Path, uri: str) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "inside"
    write(tmp_path, "outside")
    folder.mkdir()
    os.symlink(outside, folder / "link")
    text = document(model(link("base") + include(uri.format(outside=outside))))
    (error,) = errors(folder, text)
    assert "no model" in error if uri.endswith("link") else "lies outside the folder of the file you gave" in error


def test_a_model_config_leads_to_no_file_outside(tmp_path: Path) -> None:
    (tmp_path / "secret.sdf").write_text(WHEEL, encoding="utf-8")
    inside = tmp_path / "inside"
    write(inside, "wheel", "", "empty", '<sdf version="1.9">../../secret.sdf</sdf>')
    (error,) = errors(inside, document(model(link("base") + include("model://wheel"))))
    assert "no model" in error


def test_a_model_must_not_include_itself(tmp_path: Path) -> None:
    for name, other in (("a", "b"), ("b", "a")):
        write(tmp_path, name, document(model(link("l") + include(f"model://{other}"), name)))
    (error,) = errors(tmp_path, document(model(link("base") + include("model://a"))))
    assert "the model 'model://a' includes itself" in error


def test_models_in_models_are_limited_in_depth_and_number(tmp_path: Path) -> None:
    deep = model(link("l"))
    for _ in range(25):
        deep = model(link("l") + deep)
    assert "more than 20 levels deep" in errors(tmp_path, document(deep))[0]
    for number in range(4):  # each includes the next ten times: ten thousand models
        many = "".join(include(f"model://m{number + 1}", f"<name>n{i}</name>") for i in range(10)) if number < 3 else ""
        write(tmp_path, f"m{number}", document(model(link("l") + many, f"m{number}")))
    whole = document(model("".join(include("model://m0", f"<name>n{i}</name>") for i in range(10))))
    assert "more than 5000 models" in "\n".join(errors(tmp_path, whole))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot name='r'/>", "begins with <robot>"),
        ("<sdf version='1.9'>", "XML syntax"),
        ("<!DOCTYPE x><sdf version='1.9'/>", "document type"),
        (document(""), "has no <model>"),
        (document(model(link("l")), "3.0"), "SDF version '3.0' is not supported"),
    ],
)
def test_other_files_are_not_included(tmp_path: Path, text: str, message: str) -> None:
    write(tmp_path, "wheel", text)
    assert message in "\n".join(errors(tmp_path, document(model(link("base") + include("model://wheel")))))


def test_an_include_needs_a_uri(tmp_path: Path) -> None:
    for content in ("<include/>", "<include><uri/></include>", include("x" * 2000)):
        assert "an include without <uri>" in errors(tmp_path, document(model(link("base") + content)))[0]


def test_the_model_folders_are_the_siblings_of_a_folder_with_a_model_config(tmp_path: Path) -> None:
    for name in ("robot", "wheel"):
        write(tmp_path, name, config="<name>x</name>")
    write(tmp_path, "other")
    assert model_folders(tmp_path / "robot" / "model.sdf") == [tmp_path / "robot", tmp_path / "wheel"]
    assert model_folders(tmp_path / "other" / "model.sdf") == []
