"""Where packages are found: around the description, in the robot file's paths, in what the user allowed or installed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from graphengine.descriptions.files.packages import Packages
from graphengine.format.diagnostics import Findings
from graphengine.format.files import Files
from graphengine.format.scene_spec import SceneSpec
from graphengine.format.spec_reader import read
from graphengine.physics.loading import load_world
from tests.physics.harness import CART, Project

TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
MANIFEST = '<package format="3"><name>{}</name></package>'


def package(folder: Path, name: str = "") -> Path:
    """A package with a mesh, and a manifest if it has a name of its own."""
    (folder / "meshes").mkdir(parents=True)
    (folder / "meshes/body.obj").write_text(TETRAHEDRON, encoding="utf-8")
    if name:
        (folder / "package.xml").write_text(MANIFEST.format(name), encoding="utf-8")
    return folder


def robot_with(mesh: str) -> str:
    return CART.replace('<box size=".4 .3 .1"/>', f'<mesh filename="{mesh}"/>')


def packages(folder: Path, *paths: Path, installed: tuple[Path, ...] = ()) -> Packages:
    return Packages(folder, paths, Files((folder.resolve(), *paths, *installed), installed=installed))


@pytest.mark.parametrize("place", ["cart", "src/cart", "src/repository/cart", "src/a/b/cart"])
def test_a_package_is_found_by_its_folder_below_a_path(tmp_path: Path, place: str) -> None:
    assert packages(tmp_path, tmp_path).find("cart") is None
    package(tmp_path / place)
    assert packages(tmp_path, tmp_path).find("cart") == tmp_path / place


def test_a_package_path_may_be_a_package_or_a_folder_of_packages(tmp_path: Path) -> None:
    package(tmp_path / "src/cart-main", "cart")
    assert packages(tmp_path, tmp_path / "src").find("cart") == tmp_path / "src/cart-main"
    assert packages(tmp_path, tmp_path / "src/cart-main").find("cart") == tmp_path / "src/cart-main"


def test_a_readable_package_takes_precedence_over_one_outside_the_permitted_folders(tmp_path: Path) -> None:
    package(tmp_path / "cart", "cart")
    package(tmp_path / "src/cart", "cart")
    (tmp_path / "robot").mkdir()
    assert packages(tmp_path / "robot", tmp_path / "src").find("cart") == tmp_path / "src/cart"
    assert packages(tmp_path / "robot").find("cart") == tmp_path / "cart"  # and is told to be outside


def test_folders_within_packages_and_hidden_folders_are_no_packages(tmp_path: Path) -> None:
    package(tmp_path / "src/cart", "cart")
    package(tmp_path / "src/cart/inner/wheel")
    package(tmp_path / "src/.cache/old/arm")
    found = packages(tmp_path, tmp_path / "src")
    assert [found.find("wheel"), found.find("arm")] == [None, None]


@pytest.mark.parametrize(
    "reference", ["package://cart/meshes/body.obj", "model://cart/meshes/body.obj", "../meshes/body.obj"]
)
def test_a_description_in_its_own_package_finds_its_meshes(project: Project, reference: str) -> None:
    package(project.folder / "cart_ws-1.2", "cart")
    project.write("cart_ws-1.2/urdf/cart.urdf", robot_with(reference))
    project.write("bot.yaml", "robot: bot\nurdf: cart_ws-1.2/urdf/cart.urdf\n")
    assert project.load().simulation.model.nmesh == 1


def test_a_folder_of_another_name_without_a_manifest_can_stand_for_a_package(
    project: Project,
) -> None:
    package(project.folder / "downloaded")
    project.write("downloaded/urdf/cart.urdf", robot_with("package://cart/meshes/body.obj"))
    project.write("bot.yaml", "robot: bot\nurdf: downloaded/urdf/cart.urdf\n")
    assert project.load().simulation.model.nmesh == 1
    assert "no package 'cart'" in project.write("downloaded/package.xml", MANIFEST.format("wagon")).error()


def test_package_paths_are_relative_to_the_file_that_contains_them(project: Project) -> None:
    package(project.folder / "base/src/cart", "cart")
    project.write("bot.urdf", robot_with("package://cart/meshes/body.obj"))
    project.write("base/base.yaml", "robot: base\nurdf: ../bot.urdf\npackage_paths: [src]\n")
    project.write("bot.yaml", "robot: bot\nextends: base/base.yaml\n")
    assert project.load().simulation.model.nmesh == 1


def test_files_with_absolute_paths_and_escaped_names_are_found(project: Project) -> None:
    package(project.folder / "a folder")
    project.write("bot.urdf", robot_with((project.folder / "a folder/meshes/body.obj").as_uri()))
    assert "%20" in (project.folder / "bot.urdf").read_text(encoding="utf-8")
    assert project.load().simulation.model.nmesh == 1


def test_a_missing_mesh_is_reported_with_the_searched_folders(project: Project) -> None:
    package(project.folder / "cart", "cart")
    error = project.write("bot.urdf", robot_with("package://cart/meshes/bdy.obj")).error()
    assert "bot.urdf:4:42: error S101: no file 'package://cart/meshes/bdy.obj'" in error
    assert "did you mean 'body.obj'?" in error
    assert "looked in: cart/meshes" in error


def test_missing_meshes_of_one_folder_are_one_error(project: Project) -> None:
    names = [f"cart/meshes/part_{number}.obj" for number in range(3)] + ["other/wheel.obj"]
    shapes = "".join(
        f'<{part}><geometry><mesh filename="{name}"/></geometry></{part}>\n'
        for name in names
        for part in ("visual", "collision")
    )
    box = '<collision><geometry><box size=".4 .3 .1"/></geometry></collision>'
    cart, other = project.cart(box, shapes).errors()
    assert "bot.urdf:4:39: error S101: no file 'cart/meshes/part_0.obj', nor 2 more in the same folder" in cart
    assert "also missing: cart/meshes/part_1.obj, cart/meshes/part_2.obj" in cart
    assert "no file 'other/wheel.obj'\n" in other


def test_missing_meshes_of_a_world_are_one_error(project: Project) -> None:
    assets = "".join(f'<mesh file="{name}.stl"/>' for name in ("a", "b", "c"))
    assert "no file 'a.stl', nor 2 more in the same folder" in project.world(before=f"<asset>{assets}</asset>").error()


@pytest.mark.parametrize("name", ["arm", "base", "robots", "sensors"])
def test_a_package_is_never_found_among_the_included_graphs_and_scenes(tmp_path: Path, name: str) -> None:
    (tmp_path / "ws").mkdir()
    (tmp_path / "bots").mkdir()
    files = Files.of(tmp_path / "bots/bot.urdf", [tmp_path / "ws"])
    assert Packages(tmp_path / "bots", (), files).find(name) is None
    package(tmp_path / "ws" / name, name)
    assert Packages(tmp_path / "bots", (), files).find(name) == tmp_path / "ws" / name


def test_a_missing_package_is_reported_with_the_searched_folders_and_the_packages_found(project: Project) -> None:
    package(project.folder / "src/cart", "cart")
    error = project.write("bot.urdf", robot_with("package://crt/meshes/body.obj")).robot("package_paths: [src]").error()
    assert "did you mean 'cart'?" in error
    assert "no package 'crt'; searched for it: around " in error
    assert "src" in error
    assert "name its folder by package_paths in the robot file" in error


@pytest.mark.parametrize(
    ("path", "told"),
    [
        ("/usr/share", "bot.yaml:3:17: error S103: '/usr/share' lies outside the folder of the file you gave"),
        ("..", "allow it with --allow "),
        ("sorce", "bot.yaml:3:17: error S101: no folder 'sorce'"),
    ],
)
def test_package_paths_that_are_missing_or_outside_of_the_package_are_reported(
    project: Project, path: str, told: str
) -> None:
    assert told in project.robot(f"package_paths: [{path}]").error()


def errors(project: Project, allowed: Sequence[Path] = (), installed: Sequence[Path] = ()) -> list[str]:
    findings = Findings()
    path = project.folder / "scene.yaml"
    scene = read(SceneSpec, path, findings)
    assert scene is not None
    world = load_world(scene, Files.of(path, allowed, installed=installed), findings)
    if world is not None:
        world.simulation.close()
    return [finding.message for finding in findings.errors]


def test_packages_in_folders_that_the_user_allowed_or_installed_are_found(
    project: Project, tmp_path_factory: pytest.TempPathFactory
) -> None:
    share = tmp_path_factory.mktemp("share")
    package(share / "cart", "cart")
    project.write("bot.urdf", robot_with("package://cart/meshes/body.obj"))
    assert errors(project) == ["no file 'package://cart/meshes/body.obj'"]
    assert errors(project, allowed=[share]) == []
    assert errors(project, installed=[share]) == []


def test_links_may_leave_installed_packages_but_not_allowed_folders(
    project: Project, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """As `colcon build --symlink-install` leaves them."""
    source, share = tmp_path_factory.mktemp("src"), tmp_path_factory.mktemp("share")
    package(source / "cart", "cart")
    (share / "cart").mkdir()
    (share / "cart/package.xml").symlink_to(source / "cart/package.xml")
    (share / "cart/meshes").symlink_to(source / "cart/meshes")
    project.write("bot.urdf", robot_with("package://cart/meshes/body.obj"))
    assert errors(project, installed=[share]) == []
    (refused,) = errors(project, allowed=[share])
    assert "lies outside" in refused
    (source / "secret.obj").write_text(TETRAHEDRON, encoding="utf-8")
    project.write("bot.urdf", robot_with("package://cart/meshes/../../secret.obj"))
    (refused,) = errors(project, installed=[share])
    assert "lies outside" in refused
