#!/usr/bin/python3
"""Floors under the accuracy of the default profile, on the first seconds of rendered scenes.

accuracy_test.py TOOLS WORK [unittest's arguments]: programs are run from TOOLS; bags and results
stand in WORK while the test runs. Rendering and mapping are deterministic, so the margins are not
for chance but for changes that trade one figure for another.
"""
import json
import math
import os
import shutil
import subprocess
import sys
import unittest

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../.."))
sys.path.insert(0, os.path.join(SOURCE, "scripts"))
from accuracy import mounting, scoring  # noqa: E402

TOOLS, WORK = sys.argv[1:3]

# (figure, worst that is accepted); a negative sign: at least, otherwise at most.
LAB_NORMAL = {"false_percent": 1.0, "median_error_cm": 1.0, "p90_error_cm": 4.0,
              "recall_percent": -93.0, "map_false_cells_percent": 6.0,
              "map_coverage_percent": -85.0, "free_beyond_percent": 1.5, "free_way_percent": -75.0}
LAB_HARD = {"false_percent": 4.0, "median_error_cm": 2.0, "recall_percent": -82.0,
            "map_coverage_percent": -85.0, "free_beyond_percent": 1.5}
MOUNTING = ("x", "y", "z", "pitch")


def run(tool, *arguments):
    words = [os.path.join(TOOLS, tool)] + [str(a) for a in arguments]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(words)} gave {done.returncode}:\n{done.stdout}")


class Drive:
    """The first frames of a scene, rendered, with changes of it."""

    def __init__(self, scene, frames, *changes):
        base = os.path.join(WORK, scene)
        self.scene, self.frames = scene, frames
        self.bag, self.truth = base + ".bag", base + ".truth.json"
        run("sim_to_bag", os.path.join(SOURCE, "sim/scenes", scene + ".yaml"), self.bag,
            "--truth", self.truth, "--frames", frames,
            *(word for change in changes for word in ("--set", change)))

    def camera(self):
        with open(self.truth) as file:
            return json.load(file)["scene"]["camera"]

    def mapped(self, *options):
        """Folder of offline_mapper's run."""
        out = os.path.join(WORK, "run")
        shutil.rmtree(out, ignore_errors=True)
        run("offline_mapper", self.bag, "--out", out, "--truth", self.truth, *options)
        return out

    def settled(self, settings):
        """Figures from where self-calibration is expected to have settled."""
        truth = scoring.Truth(self.truth)
        out = self.mapped(*(word for each in settings for word in ("--set", each)))
        return scoring.score(truth, scoring.Run(out).since(mounting.settled_at(truth)))

    def figures(self, *options):
        """What scripts/score says of offline_mapper's run."""
        out = self.mapped(*options)
        score = subprocess.run(
            ["/usr/bin/python3", os.path.join(SOURCE, "scripts/score"), self.truth, out, "--json"],
            stdout=subprocess.PIPE, check=True, text=True)
        return json.loads(score.stdout)


def below_floor(figures, floors):
    """Descriptions of the figures that are worse than their floor."""
    worse = []
    for name, bound in floors.items():
        value = figures[name]
        good = value is not None and (value >= -bound if bound < 0 else value <= bound)
        if not good:
            worse.append(f"{name} is {value}, accepted is {'>=' if bound < 0 else '<='} {abs(bound)}")
    return worse


class AccuracyTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(WORK, ignore_errors=True)
        os.makedirs(WORK)
        cls.addClassCleanup(shutil.rmtree, WORK, ignore_errors=True)
        cls.normal = Drive("lab_normal", 60)

    def test_default_stays_over_its_floors_in_soft_light(self):
        figures = self.normal.figures()
        self.assertGreater(figures["visible_bearings"], 1000)
        self.assertEqual(below_floor(figures, LAB_NORMAL), [])

    def test_a_camera_pitch_stated_two_degrees_wrong_falls_through_the_floors(self):
        camera = self.normal.camera()
        for error in (-2, 2):
            stated = [camera[k] for k in MOUNTING]
            stated[3] += math.radians(error)
            # One word: a negative pitch must not look like an option.
            figures = self.normal.figures("--camera-pose=" + ",".join(map(str, stated)))
            self.assertGreaterEqual(len(below_floor(figures, LAB_NORMAL)), 2, f"{error} degrees")

    def test_self_calibration_recovers_what_a_wrongly_stated_camera_costs(self):
        # The floor does not show odometry's scale: without an error of it there is no excuse.
        drive = Drive("lab_normal", 100, "odometry.scale=0")
        camera = mounting.Camera(scoring.Truth(drive.truth))
        true = drive.settled(camera.stated(0, 0))
        self.assertGreater(true["visible_bearings"], 1000)
        for sign, errors in mounting.APPLIED.items():
            stated = camera.stated(*errors)
            wrong, applied = drive.settled(stated), drive.settled((*stated, mounting.APPLY))
            self.assertIn("median cm", mounting.lost(true, wrong), sign)
            self.assertEqual(mounting.lost(true, applied), [], sign)

    def test_somebody_who_crosses_is_found(self):
        drive = Drive("moving_things", 60)
        ignored = drive.figures("--set", "sweep/moving_score=0")["kinds"]["moving"]
        found = drive.figures()
        self.assertGreater(ignored["visible_bearings"], 300)
        self.assertLess(ignored["recall_percent"], 8.0)
        self.assertGreater(found["kinds"]["moving"]["recall_percent"], 20.0)
        self.assertLess(found["false_percent"], 4.0)

    def test_default_stays_over_its_floors_on_a_mirror_floor_under_bare_lamps(self):
        figures = Drive("lab_hard", 50).figures()
        self.assertGreater(figures["visible_bearings"], 1000)
        self.assertEqual(below_floor(figures, LAB_HARD), [])

    def test_default_sees_nothing_on_an_empty_tiled_floor(self):
        figures = Drive("empty_tiles", 40).figures()
        self.assertGreater(figures["frames_used"], 20)
        self.assertEqual(figures["points"], 0)
        self.assertEqual(figures["contact_bearings_percent"], 0.0)
        self.assertGreater(figures["free_bearings"], 1000)
        self.assertEqual(figures["free_beyond_percent"], 0.0)

    def test_the_source_s_own_chain_runs_as_the_baseline(self):
        figures = self.normal.figures("--profile", "paper")
        self.assertGreater(figures["frames_used"], 40)
        self.assertGreater(figures["visible_bearings"], 1000)
        # It misses what stands there and promises the floor behind it: the ceiling is no formality.
        self.assertGreater(figures["free_beyond_percent"], 4 * LAB_NORMAL["free_beyond_percent"])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
