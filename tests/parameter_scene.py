"""A small scene with parameters: a robot `bot` in the namespace `two`, with the graph `drive`."""

from __future__ import annotations

from pathlib import Path

from tests.physics.harness import SCENE, Project

DRIVE = """graph: drive
variables: {speed: {type: double, default: 1.5}}
nodes:
  Tick: OnPlaybackTick
  Read: {type: ReadVariable, inputs: {variableName: speed}}
  Control: {type: DifferentialController, inputs: {wheelRadius: 0.1, wheelDistance: 0.5}}
  Name: {type: ROS2QoSProfile, inputs: {depth: 7}}
connections:
  - Tick.tick -> Control.execIn
  - Read.value -> Control.linearVelocity
"""
NODE, NODES = "/two/bot", ("/scene", "/two/bot")
LIMIT = "drive.Control.maxLinearSpeed"


def write_scene(folder: Path) -> Path:
    """Write the scene into a folder; return its path."""
    project = Project(folder).robot("graphs: {drive: {use: drive.yaml}}").write("drive.yaml", DRIVE)
    project.write("scene.yaml", SCENE.replace("0.1]}", "0.1], namespace: two}"))
    return folder / "scene.yaml"
