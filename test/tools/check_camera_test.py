#!/usr/bin/python3
"""Command line of check_camera: finds a wrongly stated pose, says what it prints in the form that
scripts read, and names what is missing.

check_camera_test.py PATH_OF_CHECK_CAMERA
"""

import math
import os
import re
import subprocess
import tempfile
import unittest

import numpy as np
import offline_mapper_test as bags

FRAMES = 45
WAVES = [(math.cos(k * 2.4) * f, math.sin(k * 2.4) * f, 1.3 * k)
         for k, f in enumerate(np.linspace(25.0, 110.0, 14))]


def textured_floor(x):
    """Camera picture of an endless mottled floor, from x metres along; waves that a pixel cannot
    show are left out, as a lens does it."""
    v, u = np.mgrid[0:bags.HEIGHT, 0:bags.WIDTH]
    right, down = (u - 159.5) / bags.FOCAL, (v - 119.5) / bags.FOCAL
    forward = math.cos(bags.PITCH) - math.sin(bags.PITCH) * down
    fall = math.sin(bags.PITCH) + math.cos(bags.PITCH) * down
    scale = np.where(fall > 1e-3, bags.CAMERA_HEIGHT / np.maximum(fall, 1e-3), 1e3)
    along, across = scale * forward, -scale * right
    pixel_along = np.abs(scale * scale / bags.CAMERA_HEIGHT / bags.FOCAL)
    pixel_across = scale / bags.FOCAL
    grey = np.full(u.shape, 110.0)
    for a, b, phase in WAVES:
        shown = np.exp(-0.5 * ((a * pixel_along) ** 2 + (b * pixel_across) ** 2))
        grey += 9.0 * shown * np.sin(a * (along + x) + b * across + phase)
    return np.clip(np.round(grey), 0, 255).astype(np.uint8)


class CheckCamera(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.bag = os.path.join(cls.folder.name, "drive.bag")
        bags.write_bag(cls.bag, info=True, frames=FRAMES, picture=textured_floor)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def run_it(self, *arguments):
        return subprocess.run([bags.PROGRAM, *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=120,
                              cwd=self.folder.name)

    def check(self, pitch_error, height_error, *arguments):
        pose = "--camera-pose=0,0,%g,%g" % (bags.CAMERA_HEIGHT + height_error,
                                            bags.PITCH + math.radians(pitch_error))
        result = self.run_it(self.bag, pose, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "")
        return result.stdout

    def value(self, name, text):
        found = re.search(r"^%s: (-?[\d.]+) \+- ([\d.]+) \((?:stated )?(-?[\d.]+)?" % name, text,
                          re.MULTILINE)
        self.assertIsNotNone(found, text)
        return [float(number) for number in found.groups()]

    def test_finds_the_pose_that_is_stated_wrongly(self):
        for pitch_error, height_error in ((1.0, 0.0), (-1.0, 0.0), (0.0, 0.03), (0.0, -0.03)):
            text = self.check(pitch_error, height_error)
            pitch, pitch_sigma, stated = self.value("pitch_deg", text)
            self.assertAlmostEqual(pitch, math.degrees(bags.PITCH), delta=0.2, msg=text)
            self.assertAlmostEqual(stated, math.degrees(bags.PITCH) + pitch_error, delta=0.002)
            self.assertLess(pitch_sigma, 0.2)
            height, height_sigma, stated = self.value("height_m", text)
            self.assertAlmostEqual(height, bags.CAMERA_HEIGHT, delta=0.01, msg=text)
            self.assertAlmostEqual(stated, bags.CAMERA_HEIGHT + height_error, delta=0.0002)
            self.assertLess(height_sigma, 0.012)
            before, after = map(float, re.search(
                r"registration_px: ([\d.]+) as stated, ([\d.]+) as estimated", text).groups())
            if pitch_error:  # height alone is made up for by the motion
                self.assertLess(after, 0.8 * before)
            self.assertIn("change the %s" % ("pitch" if pitch_error else "height"), text)

    def test_a_true_pose_is_left_alone(self):
        self.assertIn("the stated pose fits", self.check(0.0, 0.0))

    def test_says_where_the_stated_pose_comes_from(self):
        self.assertIn("stated_pose_from: command line\n", self.check(0.0, 0.0))
        stated = ("--set", "camera/z=%g" % bags.CAMERA_HEIGHT, "--set", "camera/pitch=%g" % bags.PITCH)
        text = self.run_it(self.bag, *stated).stdout
        self.assertIn("stated_pose_from: parameters\n", text)
        self.assertIn("warning: tf does not know 'camera' in 'base_footprint'", text)
        known = os.path.join(self.folder.name, "known.bag")
        bags.write_bag(known, info=True, frames=FRAMES, picture=textured_floor, tf=True)
        text = self.run_it(known).stdout
        self.assertIn("stated_pose_from: tf\n", text)
        self.assertNotIn("warning: ", text)

    def test_writes_the_picture_where_it_is_told(self):
        out = os.path.join(self.folder.name, "made", "here")
        self.check(1.0, 0.0, "--out", out)
        self.assertGreater(os.path.getsize(os.path.join(out, "camera_check.png")), 10000)

    def refused(self, code, words, *arguments):
        result = self.run_it(*arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(words, result.stderr)
        if code == 3:
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)
            self.assertEqual(result.stdout, "")

    def test_too_little_floor_motion_exits_with_3_and_says_what_to_do(self):
        pose = "--camera-pose=0,0,%g,%g" % (bags.CAMERA_HEIGHT, bags.PITCH)
        still = os.path.join(self.folder.name, "still.bag")
        bags.write_bag(still, info=True, way=bags.standing)
        self.refused(3, "not enough floor motion", still, pose)
        self.refused(3, "drive a metre", still, pose)
        bags.write_bag(still, info=True, way=bags.standing, clock=0.15)  # the first images have no odometry
        self.refused(3, "drive a metre", still, pose)
        self.refused(3, "frames dropped: image older", still, pose)
        plain = os.path.join(self.folder.name, "plain.bag")
        bags.write_bag(plain, info=True, frames=FRAMES,
                       picture=lambda _: np.full((bags.HEIGHT, bags.WIDTH), 110, np.uint8))
        self.refused(3, "texture", plain, pose)

    def test_odometry_that_is_of_no_use_is_not_taken_for_a_robot_that_stands(self):
        pose = "--camera-pose=0,0,%g,%g" % (bags.CAMERA_HEIGHT, bags.PITCH)
        early = os.path.join(self.folder.name, "early.bag")
        bags.write_bag(early, info=True, frames=FRAMES, picture=textured_floor, clock=1000.0)
        self.refused(3, "older than all odometry on /odom", early, pose)
        late = os.path.join(self.folder.name, "late.bag")
        bags.write_bag(late, info=True, frames=FRAMES, picture=textured_floor, clock=0.15)
        self.assertIn("warning: 2 of %d frames dropped" % FRAMES, self.run_it(late, pose).stdout)

    def test_tells_how_long_the_camera_reads(self):
        readout, sigma, stated = self.value("readout_ms", self.check(0.0, 0.0))
        self.assertLess(abs(readout), 12.0)
        self.assertLess(sigma, 20.0, "the prior's")
        self.assertEqual(stated, 0.0)

    def test_tells_by_how_much_stamps_are_late(self):
        pose = "--camera-pose=0,0,%g,%g" % (bags.CAMERA_HEIGHT, bags.PITCH)
        late = os.path.join(self.folder.name, "clock.bag")
        for clock, words in ((-0.06, "late"), (0.05, "early")):
            bags.write_bag(late, info=True, frames=FRAMES + 15, picture=textured_floor, clock=clock,
                           way=lambda t: 0.25 * t + 0.1 * math.sin(2.2 * t))
            result = self.run_it(late, pose)
            self.assertEqual(result.returncode, 0, result.stderr)
            found = re.search(r"^time_offset_ms: (-?[\d.]+) \+- ([\d.]+)", result.stdout, re.MULTILINE)
            self.assertAlmostEqual(float(found.group(1)), 1000.0 * clock, delta=6.0)
            self.assertLess(float(found.group(2)), 12.0)
            advised = re.search("too %s: add (-?[\\d.]+) to camera/image_time_offset" % words,
                                result.stdout)
            self.assertAlmostEqual(float(advised.group(1)), clock, delta=0.006, msg=result.stdout)
            self.assertLess(abs(self.value("pitch_deg", result.stdout)[0] - math.degrees(bags.PITCH)),
                            0.2)

    def test_a_pose_that_is_far_off_is_not_guessed(self):
        result = self.run_it(self.bag, "--set", "calibration/max_tilt=0.002",
                             "--camera-pose=0,0,%g,%g" % (bags.CAMERA_HEIGHT, bags.PITCH + 0.03))
        self.assertEqual(result.returncode, 3)
        self.assertIn("measure the pose", result.stderr)

    def test_wrong_usage_exits_with_2_and_missing_input_with_3(self):
        self.refused(2, "--live")
        self.refused(2, "excludes", self.bag, "--live")
        self.refused(2, "--seconds", self.bag, "--seconds", "3")
        self.refused(2, "--seconds: has to be a number above 0, not '0'", "--live", "--seconds", "0")
        self.refused(2, "no parameter 'calibration/x'", self.bag, "--set", "calibration/x=1")
        self.refused(2, "camera/pitch = 24 rad", self.bag, "--camera-pose=0,0,0.4,24")
        self.refused(3, "cannot read bag", "/nowhere.bag")
        self.refused(3, "/front/image", self.bag, "--image-topic", "/front/image")


if __name__ == "__main__":
    unittest.main(verbosity=2)
