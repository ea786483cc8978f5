"""IsaacCreateRenderProduct: a sensor's prim bound to a path that helpers take."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.diagnostics import CheckError, PrimError
from graphengine.testing import RecordingContext
from nodes.core.render_product import IsaacCreateRenderProduct
from tests.nodes.harness import Player, dd100, ready

LIDAR = "/robot/Geometry/base_link/Lidar"
CAMERA = "/robot/Geometry/base_link/camera"


@pytest.fixture
def context() -> RecordingContext:
    made = RecordingContext()
    made.world.add_robot("/robot")
    made.world.add_lidar(LIDAR)
    made.world.stage.add(CAMERA, "camera")
    return made


def product(context: RecordingContext, prim: str, **inputs: Any) -> IsaacCreateRenderProduct:
    return ready(IsaacCreateRenderProduct, context, camera_prim=prim, **inputs)


def test_the_defaults_are_a_picture_of_1280_by_720_and_enabled(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    context.stop(node)
    assert (node.width, node.height, node.enabled, node.render_product_path) == (1280, 720, True, "")


def test_the_path_leads_to_the_lidar(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    assert node.compute() == node.exec_out
    assert context.lidar(node.render_product_path).prim_path == LIDAR


def test_the_path_is_known_before_the_first_tick(context: RecordingContext) -> None:
    assert product(context, LIDAR).render_product_path != ""


def test_the_path_is_known_again_after_a_stop(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    before = node.render_product_path
    context.stop(node)
    node.compute()
    assert node.render_product_path == before


def test_every_execution_fires(context: RecordingContext) -> None:
    node = product(context, LIDAR)
    assert [node.compute() for _ in range(3)] == [node.exec_out] * 3


def test_disabled_it_fires_nothing(context: RecordingContext) -> None:
    node = product(context, LIDAR, enabled=False)
    assert node.compute() is None
    node.enabled = True
    assert node.compute() == node.exec_out


def test_two_nodes_with_the_same_camera_and_size_share_a_product(context: RecordingContext) -> None:
    one, other = product(context, CAMERA), product(context, CAMERA)
    assert one.render_product_path == other.render_product_path


def test_a_product_of_another_size_or_camera_is_another(context: RecordingContext) -> None:
    nodes = [product(context, CAMERA), product(context, CAMERA, width=640), product(context, LIDAR)]
    assert len({node.render_product_path for node in nodes}) == 3


def test_a_given_product_is_used_as_it_is(context: RecordingContext) -> None:
    node = product(context, LIDAR, render_product_prim=("/Render/mine",))
    node.compute()
    assert node.render_product_path == "/Render/mine"


@pytest.mark.parametrize("prim", ["/robot", "/nowhere"])
def test_what_is_no_sensor_is_refused(context: RecordingContext, prim: str) -> None:
    with pytest.raises(PrimError, match=prim):
        product(context, prim)


def test_in_a_graph_without_a_camera_the_file_is_refused(play: Player) -> None:
    text = "nodes: {Tick: OnPlaybackTick, P: CreateRenderProduct}\nconnections: [Tick.tick -> P.execIn]"
    with pytest.raises(CheckError, match="P needs its input 'cameraPrim'"):
        play.graph(text)


def test_disabled_in_a_graph_the_helper_behind_it_never_starts(play: Player) -> None:
    world = dd100()
    sensor = "/dd100/Geometry/base_link/chassis_link/sim_lidar/Lidar"
    text = f"""
        nodes:
          Tick: OnPlaybackTick
          Product: {{type: CreateRenderProduct, inputs: {{cameraPrim: {sensor}, enabled: false}}}}
          Helper: RtxLidarHelper
        connections:
          - Tick.tick -> Product.execIn
          - Product.execOut -> Helper.execIn
          - Product.renderProductPath -> Helper.renderProductPath
        """
    playing = play.graph(text, world)
    world.lidar(world.stage.find(sensor)).see([1.0] * 5)
    playing.tick(3)
    assert playing.topics["Helper"] == "/dd100_0000/sim_lidar/scan"
    assert playing.published("/dd100_0000/sim_lidar/scan") == []
    playing.set("Product", "enabled", True)
    playing.tick()
    assert len(playing.published("/dd100_0000/sim_lidar/scan")) == 1
