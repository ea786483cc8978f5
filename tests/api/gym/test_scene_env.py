"""Gymnasium environments of scenes: spaces, actions, observations, seeds and processes."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import numpy as np
import pytest
from gymnasium.spaces import Box, Dict
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import TimeLimit

import graphengine as ge
from tests.api.gym.conftest import CMD_VEL, DRIVE, ODOM, SCAN, Make
from tests.api.test_robot_command import ROBOT, SCENE, URDF
from tests.other_process import in_another_process
from tests.physics.pictures.harness import needs_opengl
from tests.recording.harness import NOISY_ROBOT, NOISY_SCENE, put

SPEED, TURN = 1.3, 4.0  # m/s, rad/s: inputs of the graph cmd_vel of the dd100


@pytest.fixture
def bench(tmp_path: Path) -> ge.Scene:
    """A fixed base: joint slide from -9 to 1 m, at most 20 m/s; joint spin without limits of its position."""
    for name, text in {"bench.urdf": URDF, "bench.yaml": ROBOT, "scene.yaml": SCENE}.items():
        put(tmp_path / name, text)
    return ge.load(tmp_path / "scene.yaml")


def noisy(folder: Path) -> ge.Scene:
    put(folder / "noisy_robot.yaml", NOISY_ROBOT)
    return ge.load(put(folder / "scene.yaml", NOISY_SCENE))


def episode(scene: ge.Scene, seed: int) -> bytes:
    """All bytes that an episode of five steps returns, in a new environment."""
    env = ge.gym.SceneEnv(scene, **{**DRIVE, "observation": ge.gym.Observation(f"{SCAN}.ranges"), "ticks": 6})
    try:
        return returned(env, seed)
    finally:
        env.close()


def returned(env: ge.gym.SceneEnv, seed: int | None) -> bytes:
    said = [env.reset(seed=seed)[0].tobytes()]
    for turn in (0.0, 0.5, -0.5, 1.0, -1.0):
        observation, reward, *_ = env.step(np.array([0.5, turn], np.float32))
        said += [observation.tobytes(), np.float64(reward).tobytes()]
    return b"".join(said)


def test_gymnasiums_checker_finds_nothing(make: Make) -> None:
    check_env(make(), skip_render_check=True)
    scan, odom = ge.gym.Observation(f"{SCAN}.ranges"), ge.gym.Observation(f"{ODOM}.twist.twist", low=-9.0, high=9.0)
    check_env(make(observation={"scan": scan, "odom": odom}, ticks=6), skip_render_check=True)


@needs_opengl
def test_images_are_rendered(make: Make) -> None:
    env = make(render_mode="rgb_array", view="top", size=(64, 48), ticks=6)
    check_env(env)
    assert env.metadata["render_fps"] == 10.0  # 60 ticks a second
    env.reset(seed=1)
    pixels = env.render()
    assert pixels is not None
    assert pixels.shape == (48, 64, 3)
    assert make().render() is None


def test_an_episode_with_the_same_seed_is_the_same_byte_for_byte(tmp_path: Path) -> None:
    scene = noisy(tmp_path)
    expected = episode(scene, 7)
    env = ge.gym.SceneEnv(scene, **{**DRIVE, "observation": ge.gym.Observation(f"{SCAN}.ranges"), "ticks": 6})
    assert returned(env, 8) != expected
    assert returned(env, 7) == expected
    second, third = returned(env, None), returned(env, None)  # seeds drawn from np_random
    assert len({expected, second, third}) == 3
    assert returned(env, 7) == expected
    assert returned(env, None) == second
    env.close()
    assert in_another_process(episode_in, tmp_path) == expected


def episode_in(folder: Path) -> bytes:
    return episode(noisy(folder), 7)


def test_velocities_are_shares_of_the_limits_of_the_graph_that_reads_the_topic(make: Make) -> None:
    env = make()
    assert env.action_space == Box(-1.0, 1.0, (2,))
    env.reset(seed=1)
    for action, expected in [((0.5, -1.0), (0.5 * SPEED, -TURN)), ((3.0, 0.0), (SPEED, 0.0))]:
        env.step(np.array(action, np.float32))
        assert env.sim.value("SubscribeTwist.linearVelocity")[0] == pytest.approx(expected[0])
        assert env.sim.value("SubscribeTwist.angularVelocity")[2] == pytest.approx(expected[1])


def test_limits_of_velocities_can_be_given_and_a_sideways_speed_makes_three_numbers(make: Make) -> None:
    env = make(action=ge.gym.BaseVelocity(CMD_VEL, linear=0.2, angular=0.4, lateral=0.3))
    env.reset(seed=1)
    env.step(np.array([1.0, -0.5, 0.5], np.float32))
    assert env.sim.value("SubscribeTwist.linearVelocity") == pytest.approx((0.2, -0.15, 0.0))
    assert env.sim.value("SubscribeTwist.angularVelocity") == pytest.approx((0.0, 0.0, 0.2))


def test_targets_of_joints_span_the_limits_of_the_description(make: Make, bench: ge.Scene) -> None:
    slide = ge.gym.JointTargets("bench", "positions", ["slide"])
    spin = ge.gym.JointTargets("bench", "velocities", ["spin"])
    glide = ge.gym.JointTargets("bench", "efforts", ["glide"], low=-10.0, high=30.0)
    joint = ge.gym.Observation(lambda sim: sim.robots["bench"].joints["slide"].position, low=-9.0, high=1.0)
    env = make(bench, action=[slide, spin, glide], observation=joint, reward=lambda env: 0.0)
    assert env.action_space == Box(-1.0, 1.0, (3,))
    for action, expected in [((1.0, -1.0, 1.0), (1.0, -20.0, 30.0)), ((0.0, 0.5, -1.0), (-4.0, 10.0, -10.0))]:
        env.reset(seed=1)
        env.step(np.array(action, np.float32))
        data = env.sim.mujoco.data
        assert data.actuator("bench/slide.position").ctrl[0] == pytest.approx(expected[0])
        assert data.actuator("bench/spin.velocity").ctrl[0] == pytest.approx(expected[1])
        assert data.joint("bench/glide").qfrc_applied[0] == pytest.approx(expected[2])


def test_observations_come_from_ports_topics_and_functions_with_their_limits(make: Make) -> None:
    sources: dict[str, ge.gym.Observation] = {
        "scan": ge.gym.Observation(f"{SCAN}.ranges"),
        "pose": ge.gym.Observation(f"{ODOM}.pose.pose"),
        "port": ge.gym.Observation("ComputeOdom.position", low=[-1.0, -2.0, -3.0], high=3.0),
        "input": ge.gym.Observation("DiffController.maxLinearSpeed", high=2.0),  # the port is bounded by 0
        "beams": ge.gym.Observation("dd100.sensors.sim_lidar.ranges", low=0.0, high=9.0),
        "time": ge.gym.Observation(lambda sim: sim.time, low=0.0),
        "bytes": ge.gym.Observation(lambda sim: np.full((2, 2), sim.tick, np.uint8)),
    }
    env = make(observation=sources, ticks=6)
    space = env.observation_space
    assert isinstance(space, Dict)
    observed, _ = env.reset(seed=1)
    lidar = env.sim.subscribe(SCAN)
    assert space["pose"] == Box(-math.inf, math.inf, (7,))
    assert space["port"] == Box(np.array([-1.0, -2.0, -3.0], np.float32), np.full(3, 3.0, np.float32))
    assert space["input"] == Box(0.0, 2.0, (1,))
    assert space["bytes"] == Box(0, 255, (2, 2), np.uint8)
    assert observed["bytes"].tolist() == [[1, 1], [1, 1]]
    observed, *_ = env.step(np.zeros(2, np.float32))
    assert observed["time"] == pytest.approx(7 / 60)
    assert observed in space
    assert lidar.latest is not None
    assert space["scan"] == Box(lidar.latest.range_min, lidar.latest.range_max, lidar.latest.ranges.shape)
    assert np.isinf(lidar.latest.ranges).all()
    assert (observed["scan"] == np.float32(lidar.latest.range_max)).all()
    assert observed["beams"].shape == observed["scan"].shape
    assert (observed["beams"] == 9.0).all()


def test_a_sample_of_the_episode_before_is_not_seen(make: Make) -> None:
    env = make(observation=ge.gym.Observation("dd100.sensors.sim_lidar.index", low=0.0, high=99.0), ticks=30)
    env.reset(seed=1)
    assert env.step(np.zeros(2, np.float32))[0] > 0
    assert env.reset(seed=1)[0] == 0


def test_a_reset_begins_with_what_at_reset_changed(make: Make) -> None:
    def place(env: ge.gym.SceneEnv) -> None:
        env.sim.move("dd100", position=env.np_random.uniform(1.0, 2.0, 2).tolist())

    env = make(at_reset=place, observation=ge.gym.Observation(lambda sim: sim.robots["dd100"].pose.position[:2]))
    first, _ = env.reset(seed=5)
    assert first == pytest.approx(np.random.default_rng(5).uniform(1.0, 2.0, 2), abs=1e-3)
    env.step(np.ones(2, np.float32))
    assert (env.reset(seed=5)[0] == first).all()


def test_an_episode_ends_where_the_functions_say_or_a_wrapper_does(make: Make) -> None:
    env = make(terminated=lambda env: env.sim.time > 0.05, truncated=lambda env: env.action[0] < 0.0)
    env.reset(seed=1)
    assert env.step(np.zeros(2, np.float32))[2:4] == (False, False)  # two ticks after the reset's
    assert env.step(np.zeros(2, np.float32))[2:4] == (False, False)
    assert env.step(np.array([-1.0, 0.0], np.float32))[2:4] == (True, True)
    limited = TimeLimit(make(), 2)
    limited.reset(seed=1)
    assert [limited.step(np.zeros(2, np.float32))[3] for _ in range(2)] == [False, True]
    assert limited.spec is not None
    assert limited.spec.max_episode_steps == 2


def test_a_session_that_diverged_goes_on_with_the_next_reset(make: Make) -> None:
    env = make()
    env.reset(seed=1)
    env.sim.mujoco.data.qvel[:] = math.nan
    with pytest.raises(ge.PhysicsError):
        env.step(np.zeros(2, np.float32))
    assert env.reset(seed=1)[0] in env.observation_space


def test_a_vector_of_environments_runs_in_processes(flat: ge.Scene, make: Make) -> None:
    envs = ge.gym.make_vec(functools.partial(ge.gym.SceneEnv, flat, **DRIVE, ticks=6), 2)
    try:
        together = [envs.reset(seed=3)[0], envs.step(np.array([[1.0, 0.0], [0.5, 0.5]], np.float32))[0]]
        for index, action in enumerate(([1.0, 0.0], [0.5, 0.5])):
            env = make(ticks=6)
            assert (env.reset(seed=3 + index)[0] == together[0][index]).all()
            assert (env.step(np.array(action, np.float32))[0] == together[1][index]).all()
    finally:
        envs.close()
