"""The services of simulation_interfaces as a client on the network sees them."""

from __future__ import annotations

import math
import queue
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graphengine.control.service_host import ServiceHost
from graphengine.control.simulation_interfaces.server import SimulationInterfaces
from graphengine.messages import messages
from graphengine.messages.definitions import DEFINITIONS
from graphengine.messages.endpoints import QoS
from graphengine.ros.transport import DeliverRequest
from graphengine.ros.transports.memory.memory import MemoryTransport
from graphengine.ros.transports.memory.memory_services import MemoryServer
from tests.control.conftest import MakeTicking
from tests.control.harness import controlled
from tests.control.simulators import CRATE, Client, Simulator, simulator
from tests.waiting import PATIENCE

UNSUPPORTED, OK, NOT_FOUND, INCORRECT_STATE, FAILED = range(5)
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
TIME, STATE, SPAWNED = 1, 2, 4
STILL = messages.Vector3(0.0, 0.0, 0.0)
EMPTY, BOX, CONVEX_HULL, SPHERE = range(4)


def state(sim: Simulator, entity: str = "ball") -> Any:
    answer = sim.call("get_entity_state", entity=entity)
    assert answer.result.result == OK, answer.result.error_message
    return answer.state


def position(sim: Simulator, entity: str = "ball") -> tuple[float, float, float]:
    point = state(sim, entity).pose.position
    return point.x, point.y, point.z


def step(sim: Simulator, steps: int) -> Any:
    return sim.call("step_simulation", steps=steps)


def spawn(sim: Simulator, **fields: Any) -> Any:
    return sim.call("spawn_entity", **{"resource_string": CRATE, "initial_pose__pose": pose(0, 5, 1), **fields})


def pose(x: float, y: float, z: float, *turn: float) -> Any:
    return messages.Pose(messages.Point(x, y, z), messages.Quaternion(*(turn or (0.0, 0.0, 0.0, 1.0))))


def names(sim: Simulator, **filters: Any) -> list[str]:
    answer = sim.call("get_entities", **{f"filters__{name}": value for name, value in filters.items()})
    assert answer.result.result == OK, answer.result.error_message
    return list(answer.entities)


def bounds(kind: int, *points: tuple[float, float, float]) -> Any:
    found = DEFINITIONS.initial("simulation_interfaces/msg/Bounds")
    found.type, found.points = kind, [messages.Vector3(*map(float, point)) for point in points]
    return found


def set_state(sim: Simulator, target: int) -> int:
    return int(sim.call("set_simulation_state", state__state=target).result.result)


# States


def test_the_features_are_those_of_the_working_services(sim: Simulator) -> None:
    features = sim.call("get_simulator_features").features
    told = features.features.tolist()
    # Not among them: named poses, hulls, and what needs several worlds.
    assert told == [0, 1, 4, 5, 6, 8, *range(9, 15), *range(20, 27), 31, 32, 33, 44, 50]
    names = DEFINITIONS.names()
    whole = {name for name in names if name.startswith("simulation_interfaces/srv/") and "_" not in name[25:]}
    assert whole <= {kind for _, kind in sim.transport.graph().services}
    assert list(features.spawn_formats) == ["urdf", "xacro", "mjcf", "graphengine"]


@pytest.mark.parametrize(
    ("way", "codes"),
    [
        ([PAUSED], [101]),
        ([PLAYING, PLAYING], [OK, 101]),
        ([PLAYING, PAUSED, PLAYING], [OK, OK, OK]),
        ([STOPPED, STOPPED], [OK, 101]),
        ([STOPPED, PAUSED], [OK, 103]),
        ([STOPPED, PLAYING, STOPPED], [OK, OK, OK]),
        ([4], [103]),
        ([77], [103]),
    ],
)
def test_states_change_as_in_the_standard(sim: Simulator, way: list[int], codes: list[int]) -> None:
    assert [set_state(sim, target) for target in way] == codes
    found = sim.call("get_simulation_state")
    reached = [target for target, code in zip(way, codes, strict=True) if code == OK]
    assert (found.result.result, found.state.state) == (OK, reached[-1] if reached else PAUSED)


def test_quitting_ends_the_run_after_the_response(tmp_path: Path) -> None:
    with simulator(tmp_path) as sim:
        assert set_state(sim, PLAYING) == OK
        assert set_state(sim, QUITTING) == OK
        sim.run.end()
        assert sim.session.state == "stopped"


def test_the_response_comes_after_the_last_step(sim: Simulator) -> None:
    assert step(sim, 1).result.result == OK
    assert state(sim).header.stamp.nanosec == int(1e9 / 60)
    assert step(sim, 5).result.result == OK
    assert sim.session.ticks == 6
    assert sim.call("get_simulation_state").state.state == PAUSED


@pytest.mark.parametrize(("target", "steps"), [(PLAYING, 1), (STOPPED, 1), (PAUSED, 0), (PAUSED, 2**40)])
def test_illegal_numbers_of_steps_are_refused(sim: Simulator, target: int, steps: int) -> None:
    set_state(sim, target)
    assert step(sim, steps).result.result == FAILED


def test_steps_that_a_stop_cancels_fail(sim: Simulator) -> None:
    kind = "simulation_interfaces/srv/StepSimulation"
    request = DEFINITIONS.initial(f"{kind}_Request")
    request.steps = 1_000_000
    with pytest.raises(queue.Empty):
        sim.send("step_simulation", kind, messages.encode(request), 0.05)
    assert set_state(sim, STOPPED) == OK
    answers = sim._clients["step_simulation"][1]
    response = messages.decode(answers.get(timeout=PATIENCE), f"{kind}_Response")
    assert response.result.result == INCORRECT_STATE
    assert "cancelled" in response.result.error_message


@pytest.mark.parametrize("scope", [0, 255])
def test_a_full_reset_restores_the_initial_state(sim: Simulator, scope: int) -> None:
    start = position(sim)
    assert spawn(sim).result.result == OK
    step(sim, 20)
    assert sim.call("reset_simulation", scope=scope).result.result == OK
    assert position(sim) == start
    assert state(sim).header.stamp == messages.Time(0, 0)
    assert "crate" not in names(sim)


@pytest.mark.parametrize("scope", [TIME, STATE, SPAWNED])
def test_a_reset_of_one_scope_changes_nothing_else(sim: Simulator, scope: int) -> None:
    start = position(sim)
    spawn(sim)
    step(sim, 20)
    there, stamp = position(sim), state(sim).header.stamp
    assert sim.call("reset_simulation", scope=scope).result.result == OK
    assert position(sim) == (start if scope == STATE else there)
    assert state(sim).header.stamp == (messages.Time(0, 0) if scope == TIME else stamp)
    assert ("crate" in names(sim)) == (scope != SPAWNED)


def test_a_reset_of_an_unknown_scope_is_refused(sim: Simulator) -> None:
    assert sim.call("reset_simulation", scope=8).result.result == FAILED


# Entities


@pytest.mark.parametrize(
    ("filters", "found"),
    [
        ({}, ["bot", "ball", "shelf"]),
        ({"filter": "^b"}, ["bot", "ball"]),
        ({"filter": "(elf|nothing)$"}, ["shelf"]),
        ({"filter": "^[[:alpha:]]{3}$"}, ["bot"]),
        ({"filter": "nobody"}, []),
        ({"bounds": bounds(SPHERE, (5, 0, 2), (0.95, 0, 0))}, ["ball"]),
        ({"bounds": bounds(SPHERE, (5, 0, 2), (0.85, 0, 0))}, []),
        ({"bounds": bounds(BOX, (9, 9, 9), (0.5, -9, 2.5))}, ["ball", "shelf"]),
        ({"bounds": bounds(BOX, (0.5, -9, 2.5), (9, 9, 9)), "filter": "l$"}, ["ball"]),
    ],
)
def test_entities_are_found_by_name_and_by_bounds(sim: Simulator, filters: dict[str, Any], found: list[str]) -> None:
    assert names(sim, **filters) == found


@pytest.mark.parametrize(
    ("filters", "code"),
    [
        ({"filter": "("}, FAILED),
        ({"filter": "x" * 2000}, FAILED),
        ({"filter": "(?:x{9999}){9999}"}, FAILED),  # which would be written out in all of the memory that there is
        ({"filter": "(x{0009999}){1,9999}"}, FAILED),
        ({"filter": "(a|b|ab|ba|al|ll|l)*(a|b|l|ba|al)*(b|a|l)*(b|a|l|al)*c{99}"}, OK),
        ({"bounds": bounds(CONVEX_HULL, (0, 0, 0), (1, 0, 0), (0, 1, 0))}, UNSUPPORTED),
        ({"bounds": bounds(BOX, (0, 0, 0))}, FAILED),
        ({"bounds": bounds(SPHERE, (0, 0, math.nan), (1, 0, 0))}, FAILED),
        ({"bounds": bounds(9)}, UNSUPPORTED),
    ],
)
def test_illegal_filters_are_refused(sim: Simulator, filters: dict[str, Any], code: int) -> None:
    answer = sim.call("get_entities", **{f"filters__{name}": value for name, value in filters.items()})
    assert answer.result.result == code


def test_a_too_slow_regular_expression_is_refused(sim: Simulator) -> None:
    assert spawn(sim, name="a" * 60).result.result == OK
    answer = sim.call("get_entities", filters__filter="^(a|a)*[^a]")
    assert answer.result.result == FAILED
    assert "takes too long" in answer.result.error_message


def test_states_of_several_entities_equal_the_single_states(sim: Simulator) -> None:
    answer = sim.call("get_entities_states")
    assert list(answer.entities) == ["bot", "ball", "shelf"]
    assert [each.pose for each in answer.states] == [state(sim, name).pose for name in answer.entities]


def test_a_set_state_is_read_back(sim: Simulator) -> None:
    wanted = state(sim)
    assert wanted.header.frame_id == "world"
    wanted.pose = pose(1, 2, 4, 0.0, 0.0, 1.0, 0.0)
    wanted.twist = messages.Twist(messages.Vector3(1.0, 0.0, 0.0), messages.Vector3(0.0, 0.0, 2.0))
    assert sim.call("set_entity_state", entity="ball", state=wanted).result.result == OK
    found = state(sim)
    assert (found.pose, found.twist) == (wanted.pose, wanted.twist)
    assert found.acceleration.linear.z == pytest.approx(-9.81)


def test_a_pose_that_overlaps_an_entity_is_refused_and_a_pose_in_the_floor_has_a_warning(sim: Simulator) -> None:
    wanted, before = state(sim), state(sim)
    wanted.pose = pose(1, 2, 3.25)
    answer = sim.call("set_entity_state", entity="ball", state=wanted)
    assert answer.result.result == 101
    assert answer.result.error_message.startswith("ball would be 0.15 m deep in shelf: nothing was changed")
    assert state(sim).pose == before.pose
    answer = spawn(sim, initial_pose__pose=pose(1, 2, 3.0))
    assert answer.result.result == 109
    assert answer.result.error_message.startswith("crate would be ")
    assert "crate" not in sim.call("get_entities").entities
    answer = spawn(sim, initial_pose__pose=pose(4, 4, 0.1))
    assert answer.result.result == OK
    assert answer.result.error_message.startswith("crate is 0.1 m deep in the world: ")


@pytest.mark.parametrize(
    ("entity", "field", "value", "code"),
    [
        ("nobody", "pose", pose(0, 0, 0), NOT_FOUND),
        ("ball", "pose", pose(math.nan, 0, 0), 101),
        ("ball", "pose", pose(0, 0, 1e9), 101),
        ("ball", "pose", pose(0, 0, 0, 0.0, 0.0, 0.0, 0.0), 101),
        ("ball", "pose", pose(0, 0, 0, 0.0, 0.0, 0.0, 2.0), 101),
        ("ball", "header", messages.header(0.0, "moon"), FAILED),
        ("shelf", "twist", messages.Twist(messages.Vector3(1.0, 0.0, 0.0), STILL), FAILED),
        ("ball", "twist", messages.Twist(messages.Vector3(math.inf, 0.0, 0.0), STILL), FAILED),
    ],
)
def test_an_illegal_state_is_refused(sim: Simulator, entity: str, field: str, value: Any, code: int) -> None:
    before = position(sim)
    answer = sim.call("set_entity_state", **{"entity": entity, f"state__{field}": value})
    assert answer.result.result == code
    assert answer.result.error_message
    assert position(sim) == before


def test_infos_of_entities_can_be_read_and_set(sim: Simulator) -> None:
    found = {name: sim.call("get_entity_info", entity=name).info.category.category for name in names(sim)}
    assert found == {"bot": 1, "ball": 0, "shelf": 5}
    info = DEFINITIONS.initial("simulation_interfaces/msg/EntityInfo")
    info.description, info.tags, info.category.category = "a ball", ["toy", "round"], 4
    assert sim.call("set_entity_info", entity="ball", info=info).result.result == OK
    assert sim.call("get_entity_info", entity="ball").info == info
    category = DEFINITIONS.initial("simulation_interfaces/msg/EntityCategory")
    category.category = 4
    assert names(sim, categories=[category]) == ["ball"]
    assert names(sim, tags__tags=["round", "square"]) == ["ball"]
    assert names(sim, tags__tags=["round", "square"], tags__filter_mode=1) == []
    info.category.category = 3
    assert sim.call("set_entity_info", entity="ball", info=info).result.result == FAILED


def test_bounds_are_a_box_in_the_frame_of_the_entity(sim: Simulator) -> None:
    found = sim.call("get_entity_bounds", entity="shelf").bounds
    corners = [(point.x, point.y, point.z) for point in found.points]
    assert (found.type, corners) == (BOX, [(0.1, 0.2, 0.3), (-0.1, -0.2, -0.3)])


def test_unknown_entities_have_the_code_not_found(sim: Simulator) -> None:
    for service in ("get_entity_state", "get_entity_info", "get_entity_bounds", "delete_entity", "set_entity_info"):
        answer = sim.call(service, entity="bal")
        assert answer.result.result == NOT_FOUND
        assert "did you mean 'ball'?" in answer.result.error_message


# Spawning


def test_an_entity_is_spawned_at_its_pose_and_deleted(sim: Simulator) -> None:
    answer = spawn(sim, name="box", entity_namespace="store")
    assert (answer.result.result, answer.entity_name) == (OK, "box")
    assert position(sim, "box") == (0, 5, 1)
    assert sim.session.services.stage.namespaces("/box/Geometry/crate") == ["store"]
    step(sim, 6)
    assert position(sim, "box")[2] < 1
    assert sim.call("delete_entity", entity="box").result.result == OK
    assert names(sim) == ["bot", "ball", "shelf"]


def test_a_mujoco_model_can_be_spawned(sim: Simulator) -> None:
    text = "<mujoco model='can'><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
    assert spawn(sim, resource_string=text).entity_name == "can"
    step(sim, 6)
    assert position(sim, "can")[2] < 1


def test_a_pose_can_be_in_the_frame_of_an_entity(sim: Simulator) -> None:
    header = messages.header(0.0, "shelf")
    assert spawn(sim, initial_pose__header=header, initial_pose__pose=pose(0, 0, 1)).result.result == OK
    assert position(sim, "crate") == pytest.approx((1, 2, 4))


def test_an_entity_has_the_name_of_its_resource_or_with_renaming_a_free_name(sim: Simulator) -> None:
    assert spawn(sim).entity_name == "crate"
    again = spawn(sim, initial_pose__pose=pose(0, 7, 1))
    assert (again.result.result, again.entity_name) == (101, "")
    assert spawn(sim, allow_renaming=True, initial_pose__pose=pose(0, 7, 1)).entity_name == "crate_1"
    assert spawn(sim, name="ball", allow_renaming=True, initial_pose__pose=pose(0, 9, 1)).entity_name == "ball_1"


@pytest.mark.parametrize("uri", ["robots/dd100.yaml", "crate.urdf", "file://{folder}/crate.urdf"])
def test_files_of_the_scenes_folder_and_included_files_can_be_spawned(sim: Simulator, tmp_path: Path, uri: str) -> None:
    (tmp_path / "crate.urdf").write_text(CRATE, encoding="utf-8")
    answer = spawn(sim, uri=uri.format(folder=tmp_path))
    assert answer.result.result == OK, answer.result.error_message
    assert answer.entity_name == ("dd100" if "dd100" in uri else "crate")


@pytest.mark.parametrize(
    ("fields", "code", "words"),
    [
        ({"resource_string": ""}, 104, "give a uri or a resource_string"),
        ({"resource_string": "hello"}, 103, "must be a URDF or MJCF"),
        ({"uri": "https://example.org/robot.urdf"}, 103, "cannot be spawned"),
        ({"uri": "cube.usd"}, 103, "cannot be spawned"),
        ({"uri": "nowhere.urdf"}, NOT_FOUND, "no file 'nowhere.urdf'"),
        ({"uri": "/etc/hosts.urdf"}, NOT_FOUND, "no file"),
        ({"resource_string": CRATE.replace("<box", "<blob")}, 106, "unknown shape 'blob'"),
        ({"resource_string": CRATE.replace('<box size=".4 .4 .4"/>', '<mesh filename="a.stl"/>')}, 107, "a.stl"),
        ({"name": "9 lives"}, 102, "is not a valid name"),
        ({"resource_string": CRATE.replace('<robot name="crate">', "<robot>")}, 102, "give a name"),
        ({"entity_namespace": "a b"}, 105, "namespace"),
        ({"entity_namespace": "{name}"}, 105, "namespace"),
        ({"initial_pose__header": messages.header(0.0, "moon")}, 109, "unknown frame 'moon'"),
        ({"initial_pose__pose": pose(0, 0, math.nan)}, 109, "invalid position"),
        ({"initial_pose__pose": pose(0, 0, 0, 0.0, 0.0, 0.0, 0.0)}, 109, "not of length 1"),
    ],
)
def test_a_refused_spawn_has_a_reason(sim: Simulator, fields: dict[str, Any], code: int, words: str) -> None:
    answer = spawn(sim, **fields)
    assert answer.result.result == code, answer.result.error_message
    assert words in answer.result.error_message
    assert names(sim) == ["bot", "ball", "shelf"]


def test_a_file_outside_of_the_allowed_folders_is_refused(sim: Simulator, tmp_path: Path) -> None:
    outside = tmp_path.parent / "outside.urdf"
    outside.write_text(CRATE, encoding="utf-8")
    for uri in (str(outside), f"file://{outside}", "../outside.urdf"):
        answer = spawn(sim, uri=uri)
        assert answer.result.result == NOT_FOUND
        assert "lies outside the folder of the file you gave" in answer.result.error_message


def test_many_entities_are_spawned_at_once_and_failures_do_not_affect_others(sim: Simulator) -> None:
    wanted: list[Any] = []
    for name in ("one", "ball", "two"):
        one = DEFINITIONS.initial("simulation_interfaces/msg/SpawnEntity")
        one.name, one.entity_resource.resource_string = name, CRATE
        one.initial_pose.pose = pose(0, 5 + len(wanted), 1)
        wanted.append(one)
    answer = sim.call("spawn_entities", spawn_requests=wanted)
    assert answer.result.result == 150
    assert [(one.result.result, one.entity_name) for one in answer.results] == [(OK, "one"), (101, ""), (OK, "two")]
    assert names(sim) == ["bot", "one", "two", "ball", "shelf"]


def test_entities_of_the_world_cannot_be_deleted(sim: Simulator) -> None:
    answer = sim.call("delete_entity", entity="ball")
    assert answer.result.result == FAILED
    assert "is part of the world file" in answer.result.error_message


def test_spawnables_are_the_resources_that_can_be_spawned(sim: Simulator, tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "crate.urdf").write_text(CRATE, encoding="utf-8")
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "box.urdf").write_text(CRATE, encoding="utf-8")
    answer = sim.call("get_spawnables", sources=["more", "/etc", "x" * 3000, "\0"])
    uris = [spawnable.uri for spawnable in answer.spawnables]
    assert {"bot.yaml", "bot.urdf", "robots/crate.urdf", "robots/dd100.yaml"} <= set(uris)
    assert "scene.yaml" not in uris
    assert any(uri.endswith("more/box.urdf") for uri in uris)
    assert "/etc" in answer.result.error_message
    uri = next(uri for uri in uris if uri.endswith("more/box.urdf"))
    assert spawn(sim, uri=uri).result.result == OK


def test_the_current_world_has_its_name(sim: Simulator) -> None:
    world = sim.call("get_current_world").world
    assert (world.name, world.world_resource.uri) == ("test", "world.xml")


@pytest.mark.parametrize(
    "service", ["load_world", "unload_world", "get_available_worlds", "get_named_poses", "get_named_pose_bounds"]
)
def test_unsupported_services_respond_with_an_error(sim: Simulator, service: str) -> None:
    assert sim.call(service).result.result == UNSUPPORTED


def test_a_session_without_a_scene_steps_and_has_no_entities(ticking: MakeTicking) -> None:
    transport, session = MemoryTransport(), ticking().session
    with controlled(session, paused=True) as run:
        SimulationInterfaces(run.queue, None, transport, print, "/")
        client = Client(transport)
        assert client.call("step_simulation", steps=2).result.result == OK
        features = client.call("get_simulator_features").features.features.tolist()
        assert features == [*range(20, 27), 31, 32, 33]
        assert client.call("get_entities").result.result == UNSUPPORTED
        assert client.call("spawn_entity", resource_string=CRATE).result.result == UNSUPPORTED


# Peers


def test_malformed_requests_are_dropped_and_reported_once(sim: Simulator) -> None:
    kind = "simulation_interfaces/srv/GetEntities"
    for _ in range(3):
        with pytest.raises(queue.Empty):
            sim.send("get_entities", kind, b"\0\1\0\0\xff\xff\xff\xff", 0.05)
    assert len(sim.complaints) == 1
    assert names(sim) == ["bot", "ball", "shelf"]


class Impatient(MemoryTransport):
    """A network with a peer that asks as soon as a service is there, before who offers it knows."""

    def __init__(self) -> None:
        super().__init__()
        self.answers: list[bytes] = []

    def server(
        self, service: str, service_type: str, qos: QoS, deliver: DeliverRequest, node: str = ""
    ) -> MemoryServer:
        made = super().server(service, service_type, qos, deliver, node)
        client = self.client(service, service_type, qos, lambda number, data: self.answers.append(data))
        client.call(messages.encode(DEFINITIONS.initial(f"{service_type}_Request")))
        return made


def test_requests_during_the_creation_of_a_service_get_responses() -> None:
    transport = Impatient()
    ServiceHost(transport, print).add("/trigger", "std_srvs/srv/Trigger", lambda request, response: None)
    assert transport.answers == [messages.encode(DEFINITIONS.initial("std_srvs/srv/Trigger_Response"))]


def test_requests_get_responses_while_the_simulation_plays(tmp_path: Path) -> None:
    with simulator(tmp_path, paused=False, pace=1.0) as sim:
        assert names(sim) == ["bot", "ball", "shelf"]
        assert np.isfinite(position(sim)).all()
