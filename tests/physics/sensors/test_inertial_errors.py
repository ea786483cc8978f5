"""Errors of inertial units: units of data sheets, and the laws of the Allan deviation."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from graphengine.descriptions.engine import Floats
from graphengine.devices.imu import ImuSample
from graphengine.physics.sensors.imu import ImuProfile, InertialUnit
from graphengine.physics.sensors.inertial_errors import InertialErrors, TriadErrors
from tests.physics.sensors.test_imu import FREE, TURNTABLE, carried, moving, tick

RATE = 100.0
RUNS = 400


def unit(body: str = TURNTABLE, seed: int = 0, **sections: Any) -> InertialUnit:
    """A unit with the facts of a profile."""
    return carried(body, seed=seed, **ImuProfile(**{"rate": 60.0, **sections}).facts())


def readings(imu: InertialUnit, count: int) -> Floats:
    """Rows of acceleration without gravity and angular velocity."""
    samples: list[ImuSample] = []
    tick(imu, count, lambda: samples.append(imu.sample()))
    return np.array([(*sample.linear_acceleration, *sample.angular_velocity) for sample in samples])


def biases(errors: TriadErrors, sample: int) -> Floats:
    """Biases of the accelerometers at a sample, for many seeds."""
    unit = InertialErrors((errors, TriadErrors()), RATE, "/imu")
    drifts = [unit.drift(seed, sample, None) for seed in range(RUNS)]
    return np.array([(drift.correlated + drift.walk)[:3] for drift in drifts]).ravel()


def near_variance(variance: float, count: int) -> Any:
    """Within 5 standard errors of a variance over independent samples."""
    return pytest.approx(variance, rel=5 * math.sqrt(2 / count))


def test_data_sheets_are_read_in_their_units() -> None:
    profile = ImuProfile.model_validate(
        {
            "accelerometer": {"noise_density_ug": 150.0, "bias_instability_ug": 40.0, "bias_walk_ug": 60.0},
            "gyroscope": {"noise_density_dps": 0.014, "bias_instability_dph": 5.0, "bias_walk_dph": 60.0},
        }
    )
    accelerometer, gyroscope = profile.facts()["errors"]
    assert accelerometer.noise_density == pytest.approx(150e-6 * 9.80665)
    assert accelerometer.bias_instability == pytest.approx(40e-6 * 9.80665)
    assert accelerometer.bias_walk == pytest.approx(1e-6 * 9.80665)  # 60 µg after an hour is 1 µg after a second
    assert gyroscope.noise_density == pytest.approx(math.radians(0.014))
    assert gyroscope.bias_instability == pytest.approx(math.radians(5.0) / 3600.0)
    assert gyroscope.bias_walk == pytest.approx(math.radians(1.0) / 3600.0)


def test_a_profile_without_errors_or_with_errors_of_0_gives_the_same_samples() -> None:
    noise: dict[str, Any] = {"acceleration_noise": 0.1, "angular_velocity_bias": (0.1, 0.2, 0.3)}
    plain, zeros = unit(**noise), unit(**noise, accelerometer={}, gyroscope={})
    np.testing.assert_array_equal(readings(plain, 20), readings(zeros, 20))


def test_white_noise_averages_out_as_the_allan_deviation_of_white_noise_does() -> None:
    """A density N at a rate f is a deviation N sqrt(f) of a sample, and N / sqrt(t) of a mean over t seconds."""
    density, count = 0.02, 3000
    imu = unit(gyroscope={"noise_density_dps": math.degrees(density)})
    turning = readings(imu, count)[:, 3:]
    for length in (1, 10, 50):
        means = turning.reshape(-1, length, 3).mean(axis=1)
        assert means.var() == near_variance(density**2 * 60.0 / length, 3 * count // length)


@pytest.mark.parametrize("rate", [20.0, 60.0, 240.0])
def test_the_noise_of_a_density_belongs_to_the_time_that_a_sample_is_a_mean_of(rate: float) -> None:
    """A unit of 240 Hz that is read at 60 Hz gives means of 4 samples."""
    imu = unit(rate=rate, accelerometer={"noise_density_ug": 1e4})
    values: list[ImuSample] = []
    tick(imu, 1500, lambda: values.append(imu.sample()) if imu.due else None)
    deviation = np.array([sample.linear_acceleration for sample in values[1:]]).var()
    assert deviation == near_variance((1e-2 * 9.80665) ** 2 * min(rate, 60.0), 3 * len(values))


def test_the_variance_of_a_random_walk_grows_in_proportion_to_time() -> None:
    walk = TriadErrors(bias_walk=0.01)
    for sample in (25, 100, 400):
        assert biases(walk, sample).var() == near_variance(0.01**2 * sample / RATE, 3 * RUNS)


def test_bias_instability_has_the_same_variance_at_all_times_and_forgets_within_its_correlation_time() -> None:
    unstable = TriadErrors(bias_instability=0.05, bias_correlation_time=2.0)
    start, later = biases(unstable, 0), biases(unstable, 100)
    assert start.var() == near_variance(0.05**2, 3 * RUNS)
    assert later.var() == near_variance(0.05**2, 3 * RUNS)
    correlation = float(np.mean(start * later)) / 0.05**2
    assert correlation == pytest.approx(math.exp(-1.0 / 2.0), abs=5 / math.sqrt(3 * RUNS))


def test_a_scale_error_is_proportional_to_the_acceleration_including_gravity() -> None:
    sections: dict[str, Any] = {"accelerometer": {"scale_error_percent": (0.0, 0.0, 2.0)}}
    imu = moving(unit(**sections, gyroscope={"scale_error_percent": (0.0, 0.0, -1.0)}), 3.0)
    (sample,) = readings(imu, 1)
    assert sample[2] == pytest.approx(0.02 * 9.81)
    assert sample[5] == pytest.approx(0.99 * 3.0)


DRIFTING: dict[str, Any] = {
    "accelerometer": {"noise_density_ug": 150.0, "bias_instability_ug": 40.0, "bias_walk_ug": 1000.0},
    "gyroscope": {"noise_density_dps": 0.014, "bias_instability_dph": 5.0, "bias_walk_dph": 60.0},
}


def test_errors_depend_on_seed_and_sample_only() -> None:
    often, once, other = (unit(seed=seed, **DRIFTING) for seed in (0, 0, 1))
    all_of_them = readings(often, 700)  # beyond a block of random numbers
    tick(once, 700)
    np.testing.assert_array_equal(readings(once, 1), readings(often, 1))
    assert not np.any(readings(other, 700)[-1] == all_of_them[-1])


def test_errors_repeat_after_a_reset_and_go_on_after_a_checkpoint() -> None:
    imu = unit(FREE.format(height=0.3, shape="box"), **DRIFTING)
    first = readings(imu, 20)
    kept = imu._simulation.save()
    later = readings(imu, 20)
    imu._simulation.restore(kept)
    np.testing.assert_array_equal(readings(imu, 20), later)
    imu._simulation.reset()
    np.testing.assert_array_equal(readings(imu, 20), first)
