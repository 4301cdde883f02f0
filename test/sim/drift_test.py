#!/usr/bin/python3
"""The drift figures must be able to fail: what a true, a scaled and a turning trajectory get."""
import json
import math
import os
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../scripts"))
from accuracy import drift, scoring  # noqa: E402

START, FRAMES = 1000.0, 120
HEADER = ("stamp,frame,x_odom,y_odom,theta_odom,x_refined,y_refined,theta_refined,"
          "var_x,cov_xy,cov_xtheta,var_y,cov_ytheta,var_theta\n")


def arc(step, turn, frames=FRAMES):
    poses = [np.zeros(3)]
    for _ in range(frames - 1):
        poses.append(drift.compose(poses[-1], np.array([step, 0.0, turn])))
    return np.array(poses)


class Drift(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.truth_poses = arc(0.03, 0.01)
        truth = {"scene": {"camera": {}}, "camera_in_robot": {"translation": [0, 0, 0.4]},
                 "poses": [[k / 10, *pose] for k, pose in enumerate(self.truth_poses.tolist())],
                 "footprints": [], "bag_start": START}
        path = os.path.join(self.folder.name, "truth.json")
        with open(path, "w") as file:
            json.dump(truth, file)
        self.truth = scoring.Truth(path)

    def tearDown(self):
        self.folder.cleanup()

    def figures(self, odometry, refined, variance=1e-4):
        with open(os.path.join(self.folder.name, "trajectory.csv"), "w") as file:
            file.write(HEADER)
            for k, (o, r) in enumerate(zip(odometry, refined)):
                numbers = [*o, *r, variance, 0, 0, variance, 0, variance]
                file.write(f"{START + k / 10},{k}," + ",".join(f"{v:.9f}" for v in numbers) + "\n")
        return drift.figures(self.truth, drift.Trajectory(self.folder.name))

    def test_the_truth_does_not_drift_wherever_it_starts(self):
        moved = drift.compose(np.array([[3.0, -2.0, 2.5]]), self.truth_poses)
        figures = self.figures(self.truth_poses, moved)
        self.assertAlmostEqual(figures["way_m"], 0.03 * (FRAMES - 1), 3)
        for who in ("odometry", "refined"):
            for value in figures[who].values():
                self.assertLess(value, 1e-3)
        self.assertLess(figures["sigmas"], 1e-3)

    def test_a_scale_shows_per_metre(self):
        figures = self.figures(arc(0.0306, 0.01), self.truth_poses)
        self.assertAlmostEqual(figures["odometry"]["mm_per_m"], 20.0, delta=1.0)
        self.assertLess(figures["odometry"]["mrad_per_m"], 0.1)
        self.assertLess(figures["refined"]["mm_per_m"], 0.01)

    def test_a_turn_shows_as_heading_and_at_the_end(self):
        figures = self.figures(self.truth_poses, arc(0.03, 0.0103))
        per_metre = 1e3 * 0.0003 / 0.03
        self.assertAlmostEqual(figures["refined"]["mrad_per_m"], per_metre, delta=0.5)
        self.assertAlmostEqual(figures["refined"]["end_mrad"], 0.3 * (FRAMES - 1), delta=0.1)
        self.assertLess(figures["odometry"]["end_mm"], 1e-3)

    def test_sigmas_count_errors_in_standard_deviations(self):
        shifted = self.truth_poses + np.array([0.02, 0.0, 0.0]) * (np.arange(FRAMES) > 0)[:, None]
        figures = self.figures(self.truth_poses, shifted, variance=0.01 ** 2)
        self.assertAlmostEqual(figures["sigmas"], 2.0 / math.sqrt(3.0), delta=0.02)


if __name__ == "__main__":
    unittest.main()
