#!/usr/bin/python3
"""Command lines of the simulated robot's programs.

command_line_test.py PATH_OF_SIM_TO_BAG PATH_OF_SIMULATED_ROBOT
"""

import os
import subprocess
import sys
import tempfile
import unittest

SIM_TO_BAG, SIMULATED_ROBOT = sys.argv[1:3]
del sys.argv[1:3]
SCENE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../sim/scenes/sample.yaml")


def run(*words):
    return subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True, timeout=60)


class CommandLine(unittest.TestCase):
    def test_help_needs_neither_values_nor_a_master(self):
        for program in (SIM_TO_BAG, SIMULATED_ROBOT):
            for option in ("--help", "-h"):
                result = run(program, option)
                self.assertEqual(result.returncode, 0, result.stderr)
                self.assertIn("usage: " + os.path.basename(program), result.stdout)
                self.assertEqual(result.stderr, "")

    def test_a_bag_without_frames_is_wrong_usage(self):
        with tempfile.TemporaryDirectory() as folder:
            bag = os.path.join(folder, "drive.bag")
            for frames, words in (("0", "--frames 0"), ("-1", "a whole number"), ("x", "whole number")):
                result = run(SIM_TO_BAG, SCENE, bag, "--frames", frames)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(words, result.stderr)
            self.assertEqual(os.listdir(folder), [])
            self.assertEqual(run(SIM_TO_BAG, SCENE, bag, "--frames", "1").returncode, 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
