"""Scripts that take a camera's pictures from a viewport, from the import to the images."""

from __future__ import annotations

from pathlib import Path

from tests.isaac.harness import imported
from tests.jobs.harness import Job
from tests.physics.pictures.harness import needs_opengl

CAMERA = "/dd100/Geometry/base_link/chassis_link/sim_camera/RSD455/Camera_OmniVision_OV9782_Color"
SCRIPT = f"""
import omni.graph.core as og
keys = og.Controller.Keys
og.Controller.edit(
    {{"graph_path": "/World/ROS_Camera", "evaluator_name": "execution"}},
    {{
        keys.CREATE_NODES: [
            ("OnTick", "omni.graph.action.OnPlaybackTick"),
            ("createViewport", "omni.isaac.core_nodes.IsaacCreateViewport"),
            ("resolution", "omni.isaac.core_nodes.IsaacSetViewportResolution"),
            ("getRenderProduct", "omni.isaac.core_nodes.IsaacGetViewportRenderProduct"),
            ("setCamera", "omni.isaac.core_nodes.IsaacSetCameraOnRenderProduct"),
            ("cameraHelperRgb", "omni.isaac.ros2_bridge.ROS2CameraHelper"),
            ("cameraHelperInfo", "omni.isaac.ros2_bridge.ROS2CameraHelper"),
        ],
        keys.CONNECT: [
            ("OnTick.outputs:tick", "createViewport.inputs:execIn"),
            ("createViewport.outputs:execOut", "resolution.inputs:execIn"),
            ("createViewport.outputs:viewport", "resolution.inputs:viewport"),
            ("resolution.outputs:execOut", "getRenderProduct.inputs:execIn"),
            ("createViewport.outputs:viewport", "getRenderProduct.inputs:viewport"),
            ("getRenderProduct.outputs:execOut", "setCamera.inputs:execIn"),
            ("getRenderProduct.outputs:renderProductPath", "setCamera.inputs:renderProductPath"),
            ("setCamera.outputs:execOut", "cameraHelperRgb.inputs:execIn"),
            ("setCamera.outputs:execOut", "cameraHelperInfo.inputs:execIn"),
            ("getRenderProduct.outputs:renderProductPath", "cameraHelperRgb.inputs:renderProductPath"),
            ("getRenderProduct.outputs:renderProductPath", "cameraHelperInfo.inputs:renderProductPath"),
        ],
        keys.SET_VALUES: [
            ("createViewport.inputs:viewportId", 3),
            ("resolution.inputs:width", 64),
            ("resolution.inputs:height", 40),
            ("setCamera.inputs:cameraPrim", "{CAMERA}"),
            ("cameraHelperRgb.inputs:type", "rgb"),
            ("cameraHelperRgb.inputs:topicName", "rgb"),
            ("cameraHelperInfo.inputs:type", "camera_info"),
            ("cameraHelperInfo.inputs:topicName", "info"),
        ],
    }},
)
"""
SCENE = """scene: seen
world: worlds/flat_grid.xml
robots:
  dd100: {use: robots/dd100.yaml, position: [0, 0, 0.025], namespace: ""}
graphs:
  camera: {use: ROS_Camera.yaml}
"""


@needs_opengl
def test_the_classic_chain_of_scripts_publishes_images_and_their_calibration(tmp_path: Path) -> None:
    (tmp_path / "camera.py").write_text(SCRIPT, "utf-8")
    (written,), findings = imported(tmp_path / "camera.py", tmp_path)
    assert written.name == "ROS_Camera.yaml"
    assert [one.message for one in findings.items if one.code not in ("N101", "N301")] == []
    notes = [one.message for one in findings.items if one.code == "N301"]
    assert notes == ["cameraHelperInfo: a ROS2CameraHelper of type camera_info is converted to a ROS2CameraInfoHelper"]
    (tmp_path / "scene.yaml").write_text(SCENE, "utf-8")
    with Job(tmp_path / "scene.yaml") as job:
        job.run(0.5)
        images, infos = job.heard("/sim_camera/rgb"), job.heard("/sim_camera/info")
    assert len(images) > 3
    assert {(image.width, image.height, image.encoding) for image in images} == {(64, 40, "rgb8")}
    assert {(info.width, info.height) for info in infos} == {(64, 40)}
    assert [info.header.stamp for info in infos][: len(images)] == [image.header.stamp for image in images]
