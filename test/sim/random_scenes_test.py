#!/usr/bin/python3
"""Scenes out of a hat: the same for the same number, passable, accepted by the simulator, and summed
up rightly.

random_scenes_test.py PATH_OF_SIM_TO_BAG [unittest's arguments]
"""
import math
import os
import subprocess
import sys
import tempfile
import unittest
from itertools import combinations

import yaml

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../.."))
sys.path.insert(0, os.path.join(SOURCE, "scripts"))
from accuracy import advice, experiments, random_scenes, random_tables, scoring  # noqa: E402

SIM_TO_BAG = sys.argv.pop(1)
NUMBERS = range(1, 61)
ROUNDED = 0.002  # places are written to the millimetre
COMMAND = os.path.join(SOURCE, "scripts/random_scenes")


def way(drive, step=0.01):
    x = y = heading = 0.0
    places = [(x, y)]
    for segment in drive:
        for _ in range(round(segment["seconds"] / step)):
            heading += segment["w"] * step
            x += segment["v"] * step * math.cos(heading)
            y += segment["v"] * step * math.sin(heading)
            places.append((x, y))
    return places


def reach(thing):
    return thing["r"] if "r" in thing else 0.5 * math.hypot(thing["lx"], thing["ly"])


def place(thing):
    return thing["x"], thing["y"]


def figures(false, median, recall, free=0.0):
    return {"false_percent": false, "median_error_cm": median, "recall_percent": recall,
            "free_beyond_percent": free}


class Drawing(unittest.TestCase):
    def test_a_number_is_one_scene_and_another_number_is_another(self):
        made = [yaml.safe_dump(random_scenes.scene(number)) for number in NUMBERS]
        again = [yaml.safe_dump(random_scenes.scene(number)) for number in NUMBERS]
        self.assertEqual(made, again)
        bare = {yaml.safe_dump({**random_scenes.scene(number), "name": "", "seed": 0})
                for number in NUMBERS}
        self.assertEqual(len(bare), len(NUMBERS))

    def test_the_room_is_the_one_that_the_things_are_of(self):
        rooms = {number: random_scenes.room(number) for number in NUMBERS}
        self.assertEqual(set(rooms.values()), set(random_scenes.ROOMS))
        for number, room in rooms.items():
            names = {thing["name"] for thing in random_scenes.scene(number)["obstacles"]}
            self.assertTrue(names and names <= set(random_scenes.ROOM_THINGS[room]), number)

    def test_nothing_stands_in_the_way(self):
        for number in NUMBERS:
            made = random_scenes.scene(number)
            places = way(made["drive"])
            for thing in made["obstacles"]:
                near = min(math.dist(place(thing), robot) for robot in places)
                # The way is looked at every few centimetres: a little less in between.
                self.assertGreater(near, reach(thing) + random_scenes.CLEAR - 2 * ROUNDED,
                                   (number, thing["name"]))

    def test_things_stand_apart(self):
        for number in NUMBERS:
            for one, other in combinations(random_scenes.scene(number)["obstacles"], 2):
                gap = math.dist(place(one), place(other)) - reach(one) - reach(other)
                self.assertGreater(gap, random_scenes.APART - ROUNDED,
                                   (number, one["name"], other["name"]))


class Command(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def command(self, *words):
        return subprocess.run([sys.executable, COMMAND, *words], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True)

    def test_the_simulator_drives_through_all_of_them(self):
        numbers = f"{NUMBERS[0]}-{NUMBERS[-1]}"
        done = self.command("--write", numbers, "--into", self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        bag, truth_file = (os.path.join(self.folder, "drive" + end) for end in (".bag", ".json"))
        for number in NUMBERS:
            scene = os.path.join(self.folder, f"random_{number}.yaml")
            with open(scene) as file:
                self.assertEqual(yaml.safe_load(file), random_scenes.scene(number))
            done = subprocess.run([SIM_TO_BAG, scene, bag, "--truth", truth_file, "--set",
                                   "camera.width=16", "--set", "camera.height=16"],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            self.assertEqual(done.returncode, 0, done.stdout)
            truth = scoring.Truth(truth_file)
            near, _ = truth.nearest(truth.poses[:, 1:3])
            self.assertGreater(near.min(), truth.scene["robot"]["radius"] + 0.1, number)

    def test_wrong_usage(self):
        for words in ((), ("--numbers", "5-1"), ("--numbers", "1", "--docs"), ("--write", "x"),
                      ("--numbers", "1", "--detectors", "none"), ("--docs", "--seconds", "3")):
            self.assertEqual(self.command(*words).returncode, 2, words)

    def test_a_scene_elsewhere_depends_on_what_is_in_its_files(self):
        base, scene = (os.path.join(self.folder, name) for name in ("base.yaml", "scene.yaml"))
        for path, text in ((base, "seed: 1\n"), (scene, "base: base.yaml\n")):
            with open(path, "w") as file:
                file.write(text)
        case = experiments.Case("scene", path=scene)
        self.assertEqual(experiments.scene_files(case.path), [scene, base])
        before = experiments._stamp([], experiments.scene_files(case.path))
        with open(base, "w") as file:
            file.write("seed: 2\n")
        self.assertNotEqual(experiments._stamp([], experiments.scene_files(case.path)), before)


class Summary(unittest.TestCase):
    def test_statistics_and_goals(self):
        results = {number: {"default": figures(0.1 * k, 0.2 + 0.1 * k, 100.0 - k)}
                   for k, number in enumerate(range(101, 112))}
        rows = [[cell.strip() for cell in line.strip("|").split("|")]
                for line in random_tables.summary_table(results, ["default"]).splitlines()]
        self.assertEqual(rows[2][1:5], ["mean", "0.50", "0.70", "95.00"])
        self.assertEqual(rows[3][1:5], ["median", "0.50", "0.70", "95.00"])
        self.assertEqual(rows[4][1:5], ["worst tenth", "0.90", "1.10", "91.00"])
        false = sum(f["default"]["false_percent"] <= random_tables.false_goal(number)
                    for number, f in results.items())
        self.assertEqual(rows[5][1:], ["reach the goal", f"{false} of 11", "3 of 11", "4 of 11", "–"])

    def test_a_scene_without_a_contact_reaches_no_goal(self):
        results = {1: {"chain": figures(None, None, 0.0)}, 2: {"chain": figures(0.0, 0.1, 99.0)}}
        table = random_tables.summary_table(results, ["chain"])
        self.assertIn("| mean | 0.00 | 0.10 | 49.50 |", table)
        self.assertIn("| reach the goal | 1 of 2 | 1 of 2 | 1 of 2 | – |", table)

    def test_a_mirror_floor_has_its_own_goal(self):
        goals = {random_scenes.is_polished(random_scenes.scene(n)): random_tables.false_goal(n)
                 for n in NUMBERS}
        self.assertEqual(goals, {True: 0.5, False: 0.3})

    def test_the_page_has_a_place_for_the_table(self):
        with open(os.path.join(SOURCE, "docs/simulation.md")) as file:
            self.assertIn("\nhere\n", advice.with_tables(file.read(), {"random": "here"}))


if __name__ == "__main__":
    unittest.main()
