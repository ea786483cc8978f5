"""IsaacCreateViewport, IsaacSetViewportResolution and IsaacGetViewportRenderProduct: pictures of cameras, by names of windows."""

from __future__ import annotations

from typing import Any

import pytest

from graphengine.devices.camera import Camera, CameraStub
from graphengine.format.errors import ContextError
from graphengine.nodes.core.render_product import IsaacSetCameraOnRenderProduct
from graphengine.nodes.core.viewport import (
    IsaacCreateViewport,
    IsaacGetViewportRenderProduct,
    IsaacSetViewportResolution,
)
from graphengine.testing import RecordingContext
from tests.nodes.harness import computed, ready

WIDE, NARROW = "/robot/wide", "/robot/narrow"


@pytest.fixture
def context() -> RecordingContext:
    made = RecordingContext()
    for path, degrees in ((WIDE, 90.0), (NARROW, 60.0)):
        made.world.add_device(CameraStub, path, size=(640, 480), fov_deg=(degrees, 40.0))
    return made


def made(context: RecordingContext, **inputs: Any) -> str:
    """The name of a viewport that a node makes."""
    return computed(IsaacCreateViewport, context, **inputs).viewport


def product(context: RecordingContext, viewport: str) -> str:
    return computed(IsaacGetViewportRenderProduct, context, viewport=viewport).render_product_path


def show(context: RecordingContext, path: str, camera: str) -> IsaacSetCameraOnRenderProduct:
    return ready(IsaacSetCameraOnRenderProduct, context, render_product_path=path, camera_prim=camera)


@pytest.mark.parametrize(
    ("inputs", "name"), [({"name": "Front", "viewport_id": 2}, "Front"), ({"viewport_id": 2}, "2"), ({}, "Viewport")]
)
def test_a_viewport_is_selected_by_name_or_id_and_id_0_is_the_existing_viewport(
    context: RecordingContext, inputs: dict[str, Any], name: str
) -> None:
    assert made(context, **inputs) == name


def test_each_name_has_a_render_product(context: RecordingContext) -> None:
    names = [made(context, viewport_id=number) for number in (1, 2, 1)]
    one, two, again = (product(context, name) for name in names)
    assert one == again != two
    assert product(context, "Viewport") not in (one, two)


def test_a_viewport_shows_the_camera_that_was_set_in_the_default_size(context: RecordingContext) -> None:
    path = product(context, made(context, viewport_id=1))
    show(context, path, WIDE)
    camera = context.device(Camera, path)
    assert (camera.prim_path, camera.size) == (WIDE, (1280, 720))


def test_another_camera_takes_effect_when_its_node_is_executed(context: RecordingContext) -> None:
    path = product(context, made(context))
    show(context, path, WIDE)
    later = show(context, path, NARROW)
    assert context.device(Camera, path).prim_path == WIDE
    later.compute()
    assert context.device(Camera, path).prim_path == NARROW


@pytest.mark.parametrize("before", [False, True])
def test_the_size_can_be_set_before_or_after_the_camera(context: RecordingContext, before: bool) -> None:
    path = product(context, made(context, name="Front"))
    if not before:
        show(context, path, WIDE)
    held = context.device(Camera, path) if not before else None
    ready(IsaacSetViewportResolution, context, viewport="Front", width=320, height=200)
    show(context, path, WIDE).compute()
    camera = held or context.device(Camera, path)
    assert (camera.prim_path, camera.size) == (WIDE, (320, 200))


def test_a_camera_that_was_set_stays_when_the_size_changes_until_a_stop(context: RecordingContext) -> None:
    path = product(context, made(context))
    show(context, path, WIDE)
    camera = context.device(Camera, path)
    show(context, path, NARROW).compute()
    ready(IsaacSetViewportResolution, context, width=320, height=200)
    assert (camera.prim_path, camera.size) == (NARROW, (320, 200))
    context.services.render_products[path].reset()
    assert (camera.prim_path, camera.size) == (WIDE, (320, 200))


def test_a_resolution_without_viewport_name_applies_to_the_existing_viewport(context: RecordingContext) -> None:
    ready(IsaacSetViewportResolution, context, width=100, height=50)
    path = product(context, "Viewport")
    show(context, path, WIDE)
    assert context.device(Camera, path).size == (100, 50)


@pytest.mark.parametrize("size", [{"width": 0}, {"height": 8193}])
def test_a_size_out_of_range_is_refused(context: RecordingContext, size: dict[str, int]) -> None:
    with pytest.raises(ContextError, match="legal: width and height from 1 to 8192"):
        ready(IsaacSetViewportResolution, context, **size)


def test_the_error_of_an_unknown_viewport_lists_the_viewports(context: RecordingContext) -> None:
    made(context, name="Front")
    with pytest.raises(ContextError) as caught:
        product(context, "Frnt")
    assert (caught.value.message, caught.value.help) == ("there is no viewport 'Frnt'", ("viewports: Front",))


def test_a_viewport_without_a_camera_has_no_pictures(context: RecordingContext) -> None:
    with pytest.raises(ContextError, match="the viewport shows no camera"):
        context.device(Camera, product(context, made(context)))


def test_a_refused_camera_is_not_shown(context: RecordingContext, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise ContextError("too many pixels")

    path = product(context, made(context))
    with monkeypatch.context() as patch:
        patch.setattr(context.world, "device", refuse)
        with pytest.raises(ContextError, match="too many pixels"):
            show(context, path, WIDE)
    with pytest.raises(ContextError, match="the viewport shows no camera"):
        context.device(Camera, path)
