#!/usr/bin/python3
"""The scorer must be able to fail: what a perfect, a shifted and a blind detector get."""
import csv
import json
import math
import os
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "../../scripts"))
from accuracy import scoring  # noqa: E402

START = 1000.0
BOX = [[1.2, -0.3], [1.6, -0.3], [1.6, 0.5], [1.2, 0.5]]


def truth_file(folder, footprints):
    truth = {
        "scene": {"camera": {"width": 640, "height": 480, "fx": 525.0, "fy": 525.0, "cx": 319.5,
                             "cy": 239.5, "pitch": 0.4}},
        "camera_in_robot": {"translation": [0.05, 0.0, 0.45]},
        "poses": [[k / 10, 0.01 * k, 0.002 * k, 0.004 * k] for k in range(20)],
        "footprints": footprints, "bag_start": START}
    path = os.path.join(folder, "truth.json")
    with open(path, "w") as file:
        json.dump(truth, file)
    return scoring.Truth(path)


def box_truth(folder):
    return truth_file(folder, [{"name": "b", "kind": "box", "height": 0.3, "polygon": BOX}])


def write_run(folder, contacts, frames=20, free_range=lambda truth_range: 2.0, truth=None):
    """contacts(frame) gives robot coordinates; every frame has 80 free bearings."""
    angles = np.linspace(-0.65, 0.65, 80)
    points = open(os.path.join(folder, "points.csv"), "w", newline="")
    bearings = open(os.path.join(folder, "obstacles.csv"), "w", newline="")
    with points, bearings:
        p, b = csv.writer(points), csv.writer(bearings)
        p.writerow("stamp frame bearing u v x_base y_base x_odom y_odom".split())
        b.writerow("stamp frame bearing angle_rad density range_m state".split())
        for frame in range(frames):
            stamp = f"{START + frame / 10:.6f}"
            ranges = first_ranges(truth, frame, angles) if truth else np.full(80, 2.0)
            for bearing in range(80):
                b.writerow([stamp, frame, bearing, angles[bearing], 0, free_range(ranges[bearing]),
                            "free"])
            for bearing, (x, y) in enumerate(contacts(frame)):
                p.writerow([stamp, frame, bearing, 0, 0, x, y, x, y])
    return scoring.Run(folder)


def first_ranges(truth, frame, angles):
    """Distance of the first outline along angles of the robot."""
    pose = truth.pose(START + frame / 10)
    foot = truth.to_world(pose, [truth.place[:2]])[0]
    return truth.first_outlines(foot, pose[2] + angles)[0]


def perfect(truth, frame):
    """Contacts along 80 bearings where the first outline is, in robot coordinates."""
    angles = np.linspace(-0.65, 0.65, 80)
    distance = first_ranges(truth, frame, angles)
    return [(0.05 + d * math.cos(a), d * math.sin(a))
            for d, a in zip(distance, angles) if math.isfinite(d)]


class ScoreTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def figures(self, make_contacts):
        truth = box_truth(self.folder.name)
        run = write_run(self.folder.name, lambda frame: make_contacts(perfect(truth, frame)))
        return scoring.score(truth, run)

    def test_a_perfect_detector_scores_near_a_hundred_percent(self):
        figures = self.figures(lambda contacts: contacts)
        self.assertGreater(figures["recall_percent"], 99.9)
        self.assertEqual(figures["false_percent"], 0.0)
        self.assertLess(figures["median_error_cm"], 0.01)
        self.assertGreater(figures["visible_bearings"], 200)

    def test_what_moves_is_where_it_is_at_the_time(self):
        still = {"name": "b", "kind": "box", "height": 0.3, "polygon": BOX}
        moving = dict(still, way=[[0.5, 0.0, 0.0], [1.5, 0.3, -0.4]])
        truth = truth_file(self.folder.name, [moving])
        here = write_run(self.folder.name, lambda frame: perfect(
            truth.at(START + frame / 10), frame), truth=truth)
        figures = scoring.score(truth, here)
        self.assertEqual(figures["false_percent"], 0.0)
        self.assertGreater(figures["recall_percent"], 99.9)
        self.assertEqual(list(figures["kinds"]), ["moving"])
        stays = write_run(self.folder.name, lambda frame: perfect(truth, frame))
        figures = scoring.score(truth, stays)
        self.assertGreater(figures["false_percent"], 30.0)
        self.assertLess(figures["recall_percent"], 70.0)

    def test_a_map_need_not_keep_what_has_gone(self):
        moving = {"name": "b", "kind": "box", "height": 0.3, "polygon": BOX,
                  "way": [[0.5, 0.0, 0.0], [1.0, 0.0, 5.0]]}
        truth = truth_file(self.folder.name, [moving])
        run = write_run(self.folder.name, lambda frame: perfect(
            truth.at(START + frame / 10), frame), truth=truth)
        self.write_map([])
        self.assertIsNone(scoring.score(truth, run)["map_coverage_percent"])
        self.write_map([(20, 24)])
        self.assertEqual(scoring.score(truth, run)["map_false_cells_percent"], 100.0)

    def test_contacts_fifteen_centimetres_too_near_score_near_zero(self):
        figures = self.figures(lambda contacts: [(x - 0.15, y) for x, y in contacts])
        self.assertLess(figures["recall_percent"], 5.0)
        self.assertGreater(figures["false_percent"], 90.0)
        self.assertAlmostEqual(figures["median_error_cm"], 15.0, delta=1.5)

    def test_a_blind_detector_finds_nothing_and_is_never_wrong(self):
        figures = self.figures(lambda contacts: [])
        self.assertEqual(figures["recall_percent"], 0.0)
        self.assertIsNone(figures["false_percent"])

    def test_half_of_the_contacts_are_half_of_the_recall(self):
        figures = self.figures(lambda contacts: [c for c in contacts if c[1] > 0.1])
        self.assertGreater(figures["recall_percent"], 35.0)
        self.assertLess(figures["recall_percent"], 75.0)

    def free_figures(self, free_range):
        truth = box_truth(self.folder.name)
        run = write_run(self.folder.name, lambda frame: [], free_range=free_range, truth=truth)
        return scoring.score(truth, run)

    def free_beyond(self, free_range):
        return self.free_figures(free_range)["free_beyond_percent"]

    def test_free_way_is_a_share_of_the_way_to_the_first_obstacle(self):
        way = lambda free_range: self.free_figures(free_range)["free_way_percent"]
        self.assertAlmostEqual(way(lambda first: min(first, 2.0)), 100.0, delta=0.5)
        self.assertAlmostEqual(way(lambda first: 0.5 * min(first, 2.0)), 50.0, delta=1.5)
        self.assertAlmostEqual(way(lambda first: 9.0), 100.0, delta=0.5)
        self.assertEqual(way(lambda first: 0.0), 0.0)

    def test_free_ranges_up_to_the_obstacles_promise_nothing_behind_them(self):
        self.assertEqual(self.free_beyond(lambda first: min(first, 2.0)), 0.0)
        self.assertEqual(self.free_beyond(lambda first: min(first + 0.09, 2.0)), 0.0)

    def test_free_ranges_that_end_behind_the_obstacles_are_counted(self):
        blind = self.free_beyond(lambda first: 2.0)
        self.assertGreater(blind, 25.0)  # the box takes a third of the view
        self.assertLess(blind, 60.0)
        self.assertAlmostEqual(self.free_beyond(lambda first: min(first + 0.11, 2.0)), blind)

    def test_only_free_bearings_count_as_free(self):
        truth = box_truth(self.folder.name)
        run = write_run(self.folder.name, lambda frame: [])
        for row in run.bearings:
            row["state"] = "occupied" if row["bearing"] != "3" else "unknown"
        figures = scoring.score(truth, run)
        self.assertEqual(figures["free_bearings"], 0)
        self.assertIsNone(figures["free_beyond_percent"])
        self.assertGreater(figures["free_way_percent"], 50.0)  # up to contacts the way is free

    def test_contacts_on_an_empty_floor_are_counted_per_bearing(self):
        truth = truth_file(self.folder.name, [
            {"name": "rug", "kind": "box", "height": 0.007, "polygon": BOX}])
        run = write_run(self.folder.name, lambda frame: [(1.0, 0.0)] * (4 if frame < 10 else 0))
        figures = scoring.score(truth, run)
        self.assertAlmostEqual(figures["contact_bearings_percent"], 100 * 40 / 1600)
        self.assertEqual(figures["false_percent"], 100.0)
        self.assertIsNone(figures["recall_percent"])

    def test_frames_with_the_camera_in_an_obstacle_do_not_count(self):
        truth = truth_file(self.folder.name, [
            {"name": "b", "kind": "box", "height": 0.3,
             "polygon": [[-1, -1], [1, -1], [1, 1], [-1, 1]]}])
        figures = scoring.score(truth, write_run(self.folder.name, lambda frame: [(1.5, 0.0)]))
        self.assertEqual(figures["frames_used"], 0)
        self.assertEqual(figures["points"], 0)

    def write_map(self, occupied):
        """Rows count from y = -1, columns from x = 0, both in steps of 5 cm."""
        grid = np.full((40, 60), 254, np.uint8)
        for row, column in occupied:
            grid[39 - row, column] = 0
        with open(os.path.join(self.folder.name, "map.pgm"), "wb") as file:
            file.write(b"P5\n# made by hand\n60 40\n255\n" + grid.tobytes())
        with open(os.path.join(self.folder.name, "map.yaml"), "w") as file:
            file.write("image: map.pgm\nresolution: 0.05\norigin: [0.0, -1.0, 0.0]\n")

    def test_map_cells_are_false_or_cover(self):
        truth = box_truth(self.folder.name)
        run = write_run(self.folder.name, lambda frame: [])
        front = int(1.2 / 0.05)
        face = [(row, front) for row in range(14, 30)]  # y from -0.3 to 0.5
        self.write_map(face + [(29, 5)])  # and a stray cell in the open
        figures = scoring.score(truth, run)
        self.assertEqual(figures["map_occupied_cells"], 17)
        self.assertAlmostEqual(figures["map_false_cells_percent"], 100 / 17)
        self.assertGreater(figures["map_coverage_percent"], 95.0)
        self.write_map([])
        self.assertEqual(scoring.score(truth, run)["map_coverage_percent"], 0.0)


if __name__ == "__main__":
    unittest.main()
