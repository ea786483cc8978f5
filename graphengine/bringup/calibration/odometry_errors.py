"""Measures the errors of an odometry topic against the true pose, and computes noise parameters from these errors."""

from __future__ import annotations

import math

import numpy as np

from graphengine.bringup.calibration.drive_recorder import Trace
from graphengine.bringup.calibration.figures import Alphas, Covariances, Floats, Motion, Odometry
from graphengine.bringup.calibration.measuring import displacement, in_first_frame, largest, mean, mean_square, pieces

STEP, ANGLE = 0.25, 0.2
"""Distance (m) and angle (rad) between two updates of AMCL, from the defaults of update_min_d and update_min_a."""
FARTHEST = 1e6
STRAIGHT = 0.01
"""Largest angle by which the robot may turn in a step of `STEP` m for the step to count as straight, rad."""


class OdometryMeter:
    """Collects the errors of one odometry topic over several motions."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.notes: list[str] = []
        self._errors: dict[str, list[float]] = {
            name: []
            for name in ("distance", "lateral", "heading", "turn", "turn_position", "sideways", "square", "end")
        }
        self._straight: list[tuple[float, float, float, float]] = []
        self._sideways: list[tuple[float, float, float, float]] = []
        self._turns: list[tuple[float, float, float]] = []

    def take(self, motion: Motion, window: Trace) -> None:
        """Add the odometry errors of a steady motion; short motions and motions without odometry messages have no effect."""
        truth, odometry = self._published(window)
        if len(odometry) < 2:
            self.notes = [f"{self.topic}: not published during the test drives"]
            return
        true = displacement(truth)
        error = displacement(odometry) - true
        if motion.kind == "turn":
            self._take_turn(motion, true, error)
            turns = pieces(truth, odometry, FARTHEST, ANGLE)
            self._turns += [(abs(true[2]), off[2], math.hypot(off[0], off[1])) for true, off in turns]
            return
        along, across = (0, 1) if motion.kind == "straight" else (1, 0)
        distance = abs(true[along])
        if distance < STEP:
            return
        steps = [(abs(t[along]), e[along], e[across], e[2]) for t, e in pieces(truth, odometry, STEP, FARTHEST)]
        relative = math.copysign(1.0, true[along]) * error[along] / distance
        if motion.kind == "straight":
            self._straight += steps
            self._errors["distance"].append(relative)
            self._errors["lateral"].append(error[across] / distance)
            self._errors["heading"].append(error[2] / distance)
        else:
            self._sideways += steps
            self._errors["sideways"].append(relative)

    def _published(self, trace: Trace) -> tuple[Floats, Floats]:
        """Return the true and the published poses of all ticks with an odometry message, as arrays of x, y (m), yaw (rad)."""
        odometry = trace.odometry[self.topic]
        known = np.isfinite(odometry).all(axis=1)
        return trace.frames[self.topic][known], odometry[known]

    def _take_turn(self, motion: Motion, true: Floats, error: Floats) -> None:
        angle = abs(true[2])
        if angle < ANGLE:
            return
        self._errors["turn"].append(math.copysign(math.tau, true[2]) * error[2] / angle)
        if not motion.commanded.x:
            self._errors["turn_position"].append(math.hypot(error[0], error[1]) * math.tau / angle)

    def take_square(self, trace: Trace) -> None:
        """Append the errors of the odometry while the robot drove a square.

        These are the errors at the end of the square, after each `STEP` m of straight motion, and after each `ANGLE` rad of
        rotation on the spot.
        """
        truth, odometry = map(in_first_frame, self._published(trace))
        if len(odometry):
            for true, error in pieces(truth, odometry, STEP, ANGLE):
                if abs(true[2]) < STRAIGHT:
                    self._straight.append((abs(true[0]), error[0], error[1], error[2]))
                elif abs(true[2]) >= ANGLE and math.hypot(true[0], true[1]) < STEP / 2.0:
                    self._turns.append((abs(true[2]), error[2], math.hypot(error[0], error[1])))
            self._errors["square"].append(math.dist(odometry[-1, :2], truth[-1, :2]))
            self._errors["end"].append(odometry[-1, 2] - truth[-1, 2])

    def figures(self, frame: str, *, omni: bool) -> Odometry:
        """Return the errors and noise parameters of all added motions; `omni` is True for a base that can drive sideways."""
        errors = self._errors
        return Odometry(
            self.topic,
            frame,
            distance_error=mean(errors["distance"]),
            lateral_error=largest(errors["lateral"]),
            heading_error=largest(errors["heading"]),
            turn_error=mean(errors["turn"]),
            turn_position_error=mean(errors["turn_position"]),
            sideways_error=mean(errors["sideways"]),
            square_position_error=largest(errors["square"]),
            square_heading_error=largest(errors["end"]),
            alphas=self._alphas(omni=omni),
            covariances=self._covariances(),
        )

    def _alphas(self, *, omni: bool) -> Alphas:
        moved = self._straight + self._sideways
        return Alphas(
            mean_square([turn / angle for angle, turn, _ in self._turns]),
            mean_square([turn / distance for distance, _, _, turn in moved]),
            mean_square([along / distance for distance, along, _, _ in moved]),
            mean_square([position / angle for angle, _, position in self._turns])
            if self._errors["turn_position"]
            else None,
            mean_square([across / distance for distance, _, across, _ in moved]) if omni else None,
        )

    def _covariances(self) -> Covariances:
        moved = self._straight + self._sideways
        return Covariances(
            mean([along**2 / distance for distance, along, _, _ in moved]),
            mean([turn**2 / distance for distance, _, _, turn in moved]),
            mean([turn**2 / angle for angle, turn, _ in self._turns]),
        )
