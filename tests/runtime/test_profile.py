"""Profiles: what is measured on sampled ticks, while the run stays the same."""

from __future__ import annotations

from graphengine.runtime.profile import Profile
from tests.jobs.harness import Job


def profiled(ticks: int, every: int) -> tuple[Profile, Job]:
    profile = Profile(every)
    with Job("dd100_flat") as job:
        job.say("/dd100_0000/cmd_vel", 0.5, 0.1)
        for _ in range(ticks):
            profile.begin_tick(job.session.ticks, job.session.graphs)
            job.session.step()
        profile.begin_tick(job.session.ticks, job.session.graphs)
    return profile, job


def test_every_node_of_a_tick_is_counted_and_timed() -> None:
    profile, _ = profiled(30, every=1)
    nodes = {node.path: node for node in profile.nodes()}
    assert nodes["dd100/cmd_vel/DiffController"].runs == nodes["dd100/joint_states/PublishJointState"].runs == 30
    assert (nodes["dd100/cmd_vel/OnPlaybackTick"].fired, nodes["dd100/cmd_vel/SubscribeTwist"].fired) == (30, 1)
    assert all(node.seconds > 0.0 for node in nodes.values())
    assert profile.sampled == 30


def test_ticks_between_two_samples_are_not_measured() -> None:
    profile, _ = profiled(30, every=10)
    (node,) = [node for node in profile.nodes() if node.path == "dd100/joint_states/PublishJointState"]
    assert (profile.sampled, node.runs) == (3, 3)


def test_a_profiled_run_sends_the_same_bytes() -> None:
    _, often = profiled(60, every=1)
    _, seldom = profiled(60, every=7)
    _, never = profiled(60, every=10_000)
    assert often.recorder.digest == seldom.recorder.digest == never.recorder.digest


def test_after_end_nothing_is_measured_until_the_next_begin() -> None:
    profile = Profile(every=1)
    with Job("dd100_flat") as job:
        for begins in (True, False, True):
            for _ in range(10):
                if begins:
                    profile.begin_tick(job.session.ticks, job.session.graphs)
                job.session.step()
            profile.end()
    (node,) = [node for node in profile.nodes() if node.path == "dd100/joint_states/PublishJointState"]
    assert node.runs == 20
