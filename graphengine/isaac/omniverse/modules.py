"""Creates the stubs of Omniverse's modules that a script can import; functions that edit graphs record the edits."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from graphengine.isaac.omniverse import og, usd, usd_values
from graphengine.isaac.omniverse.asyncio_stub import Task, finish
from graphengine.isaac.omniverse.graph_recorder import GraphRecorder, Place
from graphengine.isaac.omniverse.og_edit import OPENED
from graphengine.isaac.omniverse.ros_writers import render_variable
from graphengine.isaac.omniverse.stubs import StubModule, StubObject

ROOTS = frozenset(("omni", "pxr", "usdrt", "isaacsim", "carb", "isaaclab", "replicator", "warp"))
"""Top-level packages of the modules that come with Isaac Sim."""

_SHAPES = ("Capsule", "Cone", "Cube", "Cylinder", "Mesh", "Plane", "Points", "Sphere")
_SCHEMAS = (*_SHAPES, "Camera", "Imageable", "Scope", "Xform", "XformCommonAPI", "Xformable")
_ARRAYS = [f"{kind}Array" for kind in ("Bool", "Double", "Float", "Int", "Int64", "String", "Token", "UChar", "UInt")]
_VECTORS = {
    f"Vec{cls.size}{kind}": cls
    for cls in (usd_values.Vector2, usd_values.Vector, usd_values.Vector4)
    for kind in "dfhi"
}


class Application(StubObject):
    """Stub of the class `SimulationApp` and of its instance: calling the stub returns the stub itself."""

    def __call__(self, *_: Any, **__: Any) -> Any:  # noqa: D102
        return self


def _sensor_type(sensor: Any) -> str:
    """Return the name of a sensor type, such as `Rgb` for the stub of `SensorType.Rgb.name`."""
    return str(sensor).removesuffix(">").removesuffix(".name").rpartition(".")[2]


def make_modules(recorder: GraphRecorder) -> dict[str, ModuleType]:
    """Return the modules with functions that record graph edits, by name; `ImportFinder` creates all other Omniverse modules.

    Args:
        recorder: recorder of the graph edits.
    """
    stage = usd.UsdStage(recorder)

    def prim_at(prim_path: Any = "", *_: Any, path: Any = "", **__: Any) -> usd.UsdPrim:
        return stage.GetPrimAtPath(prim_path or path)

    def is_valid(prim_path: Any, *_: Any, **__: Any) -> bool:
        return stage.GetPrimAtPath(prim_path).IsValid()

    def define_prim(prim_path: Any, prim_type: Any = "", *_: Any, **__: Any) -> usd.UsdPrim:
        return stage.DefinePrim(prim_path, prim_type)

    def set_attribute(prim_path: Any, attribute_name: Any, value: Any, *_: Any, **__: Any) -> None:
        stage.GetPrimAtPath(prim_path).set_property(str(attribute_name), value)

    def delete_prim(prim_path: Any, *_: Any, **__: Any) -> bool:
        return stage.RemovePrim(prim_path)

    def set_targets(prim: Any, attribute: Any, target_prim_paths: Any) -> None:
        targets = target_prim_paths if isinstance(target_prim_paths, list | tuple) else [target_prim_paths]
        if isinstance(prim, usd.UsdPrim):
            prim.set_property(str(attribute), list(targets))

    def set_target_prims(primPath: Any, targetPrimPaths: Any, inputName: Any = "inputs:targetPrim") -> None:  # noqa: N803
        if recorder.assumed and not recorder.graph_of(str(primPath)):
            recorder.leave_out(f"the value of {primPath}.{inputName} is left out: no graph has the node", "", OPENED)
            return
        graph, node = recorder.find_node(None, str(primPath))
        recorder.set_value(recorder.inner(Place(graph, node, str(inputName))), list(targetPrimPaths))

    def execute(command: Any, *_: Any, **named: Any) -> tuple[bool, Any]:
        """Execute a Kit command that deletes prims, or note any other command; return True and the prim or a stub."""
        if command in ("DeletePrims", "DeletePrimsCommand"):
            for path in named.get("paths", ()):
                delete_prim(str(path))
        elif isinstance(command, str):
            recorder.pass_over(f"the command {command}")
        parent, path = named.get("parent"), named.get("path", named.get("prim_path"))
        if isinstance(path, str):
            made = f"{(parent or '').rstrip('/')}/{path.strip('/')}"
            recorder.prims.add(made)
            return True, usd.UsdPrim(made, recorder)
        return True, StubObject(f"the command {command}", recorder)

    def open_stage(path: Any = "", *_: Any, usd_path: Any = "", **__: Any) -> bool:
        recorder.open_stage(str(path or usd_path))
        return True

    opens = {
        "open_stage": open_stage,
        "open_stage_async": lambda *given, **named: Task((open_stage(*given, **named), ""), recorder),
    }
    context = StubObject("omni.usd.get_context()", recorder)
    vars(context).update(opens, get_stage=lambda: stage)
    prims = {
        "get_prim_at_path": prim_at,
        "is_prim_path_valid": is_valid,
        "create_prim": define_prim,
        "define_prim": define_prim,
        "set_prim_attribute_value": set_attribute,
        "set_prim_property": set_attribute,
        "delete_prim": delete_prim,
        "set_targets": set_targets,
    }
    schemas = {name: usd.Schema(f"UsdGeom.{name}", stage) for name in _SCHEMAS}
    stages = {**opens, "get_current_stage": lambda *_, **__: stage, "get_stage_units": lambda *_, **__: 1.0}
    targets = {"set_target_prims": set_target_prims}
    application = {"SimulationApp": Application("SimulationApp", recorder)}
    vars(application["SimulationApp"])["run_coroutine"] = lambda coroutine, *_, **__: finish(coroutine, recorder)
    sdf = {"Path": usd_values.SdfPath}
    gf = {
        **_VECTORS,
        **dict.fromkeys(("Quatd", "Quatf", "Quath"), usd_values.Quaternion),
        "Matrix4d": usd_values.Matrix,
        "Matrix3d": usd_values.Matrix3,
        "Matrix2d": usd_values.Matrix2,
    }
    synthetic = StubObject("omni.syntheticdata.SyntheticData", recorder)
    vars(synthetic)["convert_sensor_type_to_rendervar"] = lambda sensor: render_variable(_sensor_type(sensor))
    known: dict[str, dict[str, Any]] = {
        "omni.graph.core": og.members(recorder),
        "omni.usd": {
            "get_context": lambda *_: context,
            "get_prim_at_path": prim_at,
            "get_stage_next_free_path": lambda _, path, *__: str(path),
        },
        "omni.syntheticdata": {"SyntheticData": synthetic},
        "omni.kit.commands": {"execute": execute},
        "omni.kit.async_engine": {"run_coroutine": lambda coroutine: Task(finish(coroutine, recorder), recorder)},
        "pxr.Sdf": sdf,
        "pxr.Gf": gf,
        "pxr.Vt": dict.fromkeys(_ARRAYS, list),
        "pxr.UsdGeom": {"GetStageMetersPerUnit": lambda *_: 1.0, **schemas},
        "usdrt.Sdf": sdf,
        "usdrt.Gf": gf,
        "isaacsim": application,
        "isaacsim.simulation_app": application,
        "omni.isaac.kit": application,
        "isaacsim.core.utils.prims": prims,
        "omni.isaac.core.utils.prims": prims,
        "isaacsim.core.experimental.utils.prim": {"get_prim_at_path": prim_at},
        "isaacsim.core.experimental.utils.stage": {**stages, "define_prim": define_prim},
        "isaacsim.core.utils.stage": stages,
        "omni.isaac.core.utils.stage": stages,
        "isaacsim.core.nodes.scripts.utils": targets,
        "omni.isaac.core_nodes.scripts.utils": targets,
    }
    packages = {name[:end] for name in known for end, mark in enumerate(name) if mark == "."} - known.keys()
    modules = recorder.modules
    for name in (*packages, *known):
        modules[name] = StubModule(name, recorder, modules, known.get(name, {}))
    return modules
