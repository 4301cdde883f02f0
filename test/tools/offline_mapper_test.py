#!/usr/bin/python3
"""Command line of offline_mapper: files, exit codes, one clear line for every input that is wrong.

offline_mapper_test.py PATH_OF_OFFLINE_MAPPER
"""

import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image
from tf2_msgs.msg import TFMessage

PROGRAM = sys.argv.pop(1)
WIDTH, HEIGHT, FOCAL, CAMERA_HEIGHT, PITCH = 320, 240, 260.0, 0.4, 0.45

CALIBRATION = """image_width: %d
image_height: %d
camera_name: test
camera_matrix: {rows: 3, cols: 3, data: [%f, 0, 159.5, 0, %f, 119.5, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
""" % (WIDTH, HEIGHT, FOCAL, FOCAL)


def floor_picture(x):
    """Camera picture of a chequered floor with a wall across it at 1.6 m, from x metres along."""
    v, u = np.mgrid[0:HEIGHT, 0:WIDTH]
    right, down = (u - 159.5) / FOCAL, (v - 119.5) / FOCAL
    forward = math.cos(PITCH) - math.sin(PITCH) * down
    fall = math.sin(PITCH) + math.cos(PITCH) * down
    with np.errstate(divide="ignore", invalid="ignore"):
        to_floor = np.where(fall > 0, CAMERA_HEIGHT / fall, np.inf)
        to_wall = (1.6 - x) / forward
        on_floor = to_floor < to_wall
        scale = np.where(on_floor, to_floor, to_wall)
        a = np.where(on_floor, x + scale * forward, CAMERA_HEIGHT - scale * fall)
        b = -scale * right
    pattern = np.sin(31.0 * a + 1.0) * np.sin(29.0 * b) + np.sin(47.0 * (a + b))
    grey = 110.0 + 35.0 * pattern + np.where(on_floor, 0.0, 30.0)
    return np.clip(np.nan_to_num(grey), 0, 255).astype(np.uint8)


def camera_transform(time):
    """The camera on the robot, as tf tells."""
    transform = TransformStamped()
    transform.header.stamp, transform.header.frame_id = time, "base_footprint"
    transform.child_frame_id = "camera"
    transform.transform.translation.z = CAMERA_HEIGHT
    c, s = 0.5 * math.cos(0.5 * PITCH), 0.5 * math.sin(0.5 * PITCH)
    q = transform.transform.rotation
    q.x, q.y, q.z, q.w = -c - s, c + s, s - c, c - s
    return transform


def standing(_):
    return 0.0


def write_bag(path, images=True, odometry=True, info=False, encoding="mono8", frames=12, fx=FOCAL,
              way=lambda t: 0.25 * t, wheels=1.0, picture=floor_picture, clock=0.0, tf=False,
              frame="camera", unstamped=()):
    """A robot that has driven `way` metres after so many seconds; 10 pictures a second, odometry at
    50 Hz, whose wheels see `wheels` times the way and whose clock is `clock` seconds ahead. `unstamped`:
    "images", "odometry"."""
    with rosbag.Bag(path, "w") as bag:
        if tf:
            start = rospy.Time.from_sec(1000.0)
            bag.write("/tf_static", TFMessage([camera_transform(start)]), start)
        for k in range(5 * frames - 2):
            t = rospy.Time.from_sec(1000.0 + 0.02 * k)
            x = way(0.02 * k)
            if odometry:
                message = Odometry()
                if "odometry" not in unstamped:
                    message.header.stamp = t + rospy.Duration.from_sec(clock)
                message.header.frame_id = "odom"
                message.child_frame_id = "base_footprint"
                message.pose.pose.position.x = wheels * x
                message.pose.pose.orientation.w = 1.0
                bag.write("/odom", message, t)
            if images and k % 5 == 0:
                image = Image(height=HEIGHT, width=WIDTH, encoding=encoding, step=WIDTH)
                image.header.frame_id = frame
                if "images" not in unstamped:
                    image.header.stamp = t
                image.data = picture(x).tobytes()
                bag.write("/camera/rgb/image_raw", image, t)
                if info:
                    k_matrix = [fx, 0, 159.5, 0, FOCAL, 119.5, 0, 0, 1]
                    calibration = CameraInfo(header=image.header, height=HEIGHT, width=WIDTH,
                                             distortion_model="plumb_bob", D=[0.0] * 5, K=k_matrix)
                    bag.write("/camera/rgb/camera_info", calibration, t)


class OfflineMapper(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.bag = os.path.join(self.folder.name, "test.bag")
        self.out = os.path.join(self.folder.name, "out")
        self.calibration = os.path.join(self.folder.name, "camera.yaml")
        with open(self.calibration, "w", encoding="ascii") as file:
            file.write(CALIBRATION)
        self.pose = "--camera-pose=0,0,%g,%g" % (CAMERA_HEIGHT, PITCH)

    def tearDown(self):
        self.folder.cleanup()

    def run_it(self, *arguments):
        return subprocess.run([PROGRAM, *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=120)

    def refused(self, code, words, *arguments):
        result = self.run_it(*arguments)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertIn(words, result.stderr)
        if code == 3:
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)

    def test_maps_a_bag_as_the_source_recorded_it(self):
        """/odom and images only: calibration and camera pose from the command line."""
        write_bag(self.bag)
        result = self.run_it(self.bag, "--out", self.out, "--camera-info", self.calibration,
                             self.pose)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertEqual(result.stderr, "", "silent when it is not a terminal")
        self.assertFalse(os.path.exists(os.path.join(self.out, "overlays")))
        for name in ("map.pgm", "map.yaml", "map.png", "overlay.png"):
            self.assertGreater(os.path.getsize(os.path.join(self.out, name)), 0, name)
        with open(os.path.join(self.out, "report.json"), encoding="utf-8") as file:
            report = json.load(file)
        self.assertEqual(report["frames"]["read"], 12)
        skipped = sum(report["frames"]["skipped"].values())
        self.assertEqual(report["frames"]["used"] + skipped, 12)
        self.assertGreater(report["frames"]["used"], 3)
        self.assertEqual(report["camera"]["pose_from"], "command line")
        self.check_tables(report)

    def check_tables(self, report):
        with open(os.path.join(self.out, "points.csv"), encoding="ascii") as file:
            points = list(csv.DictReader(file))
        with open(os.path.join(self.out, "obstacles.csv"), encoding="ascii") as file:
            bearings = list(csv.DictReader(file))
        self.assertEqual(len(points), report["points"])
        self.assertEqual(list(points[0]), "stamp frame bearing u v x_base y_base x_odom y_odom".split())
        self.assertEqual(list(bearings[0]), "stamp frame bearing angle_rad density range_m state".split())
        self.assertEqual(len({row["frame"] for row in bearings}), report["frames"]["used"])
        self.assertLessEqual({row["state"] for row in bearings},
                             {"free", "occupied", "blocked", "unknown"})
        # The wall stands at x = 1.6 m in the odometry frame.
        distance = sorted(abs(float(row["x_odom"]) - 1.6) for row in points)
        self.assertLess(distance[len(distance) // 2], 0.02)

    def test_warns_of_a_pose_that_is_stated_wrongly_until_it_is_applied(self):
        write_bag(self.bag, frames=40)
        def told(pitch, *arguments):
            result = self.run_it(self.bag, "--out", self.out, "--camera-info", self.calibration,
                                 "--camera-pose=0,0,%g,%g" % (CAMERA_HEIGHT, pitch), *arguments)
            self.assertEqual(result.returncode, 0, result.stderr)
            return [line for line in result.stdout.splitlines() if line.startswith("warning: ")]
        self.assertEqual(told(PITCH), [])
        warnings = told(PITCH - math.radians(1.5))
        self.assertEqual(len(warnings), 1)
        self.assertIn("lower than stated: change the pitch from 0.4238 to 0.4", warnings[0])
        self.assertEqual(told(PITCH - math.radians(1.5), "--set", "calibration/mode=apply"), [])

    def results(self, *arguments):
        """Warnings, and the files and folders that the tool says it wrote."""
        return self.told_and_named(self.pose, *arguments)

    def told_and_named(self, *arguments):
        result = self.run_it(self.bag, "--out", self.out, *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = result.stdout.splitlines()
        head = "results in %s: " % self.out
        named = [line[len(head):] for line in lines if line.startswith(head)]
        self.assertEqual(len(named), 1, result.stdout)
        return ([line[9:] for line in lines if line.startswith("warning: ")],
                sorted(name.rstrip("/") for name in named[0].split(", ")))

    def test_says_why_frames_were_dropped(self):
        for faults, words in (
                ({"wheels": math.nan}, ["none of 12 frames used", "does not reach", "(12)",
                                        "refused messages on /odom: not finite, without a stamp, or with an "
                                        "orientation that is no unit quaternion (58)"]),
                ({"clock": 1000.0}, ["none of 12 frames used", "older than all odometry on /odom (12)"]),
                ({"wheels": 1000.0}, ["none of 12 frames used", "jumps farther than odometry/max_speed"]),
                ({"way": standing}, ["none of 12 frames used", "the robot stands (11)"]),
                ({"clock": 0.15}, ["2 of 12 frames dropped: image older than all odometry"])):
            write_bag(self.bag, info=True, **faults)
            warnings, _ = self.results()
            self.assertEqual(len(warnings), 1, faults)
            for each in words:
                self.assertIn(each, warnings[0])
        write_bag(self.bag, info=True)
        self.assertEqual(self.results()[0], [])

    def warnings(self, *arguments):
        return self.told_and_named(*arguments)[0]

    def test_says_that_tf_does_not_know_the_camera(self):
        stated = ("--set", "camera/z=%g" % CAMERA_HEIGHT, "--set", "camera/pitch=%g" % PITCH)
        write_bag(self.bag, info=True)
        told = self.warnings(*stated)
        self.assertEqual(len(told), 1, told)
        self.assertIn("tf does not know 'camera' in 'base_footprint': the camera pose is taken from "
                      "the parameters camera/x ... roll (0.05, 0, 0.4 m, pitch 0.45 rad)", told[0])
        self.assertEqual(self.warnings(self.pose), [])
        self.assertEqual(self.warnings(*stated, "--set", "camera/pose_from_tf=false"), [])
        write_bag(self.bag, info=True, frame="")
        self.assertIn("the images name no frame_id: the camera pose", self.warnings(*stated)[0])

    def test_says_that_a_pose_set_by_hand_has_no_effect(self):
        write_bag(self.bag, info=True, tf=True)
        self.assertEqual(self.warnings(), [])
        told = self.warnings("--set", "camera/pitch=0.3", "--set", "camera/roll=0.1",
                             "--set", "camera/image_time_offset=0")
        self.assertEqual(len(told), 1, told)
        self.assertTrue(told[0].startswith("camera/pitch, camera/roll without effect"), told[0])
        self.assertIn("camera/pose_from_tf=false", told[0])
        self.assertEqual(self.warnings("--set", "camera/z=0.4", "--set", "camera/x=0", "--set",
                                       "camera/pitch=0.45", "--set", "camera/pose_from_tf=false"), [])
        write_bag(self.bag, info=True, tf=True, frame="/camera")
        self.assertEqual(self.warnings(), [], "tf knows no slash")

    def test_says_that_a_driver_sets_no_stamps(self):
        write_bag(self.bag, info=True, unstamped=["images"])
        self.assertEqual(self.warnings(self.pose), [
            "none of 12 frames used: image without a stamp: its header.stamp is 0 (12)"])
        write_bag(self.bag, info=True, unstamped=["odometry"])
        told = self.warnings(self.pose)[0]
        self.assertIn("refused messages on /odom: not finite, without a stamp", told)

    def test_names_the_files_that_it_wrote_and_no_others(self):
        write_bag(self.bag, info=True)
        _, named = self.results("--fpga", "--overlays", "3")
        self.assertEqual(named, sorted(os.listdir(self.out)))
        write_bag(self.bag, info=True, way=standing)
        _, named = self.results("--overlays", "3")
        self.assertFalse({"overlay.png", "overlays", "fifo.bin"} & set(named), named)
        left = set(os.listdir(self.out)) - {"overlays"}
        self.assertEqual(named, sorted(left), "a picture of the run before would mislead")

    def test_overlays_of_an_earlier_run_go_and_other_files_stay(self):
        write_bag(self.bag, info=True)
        folder = os.path.join(self.out, "overlays")
        os.makedirs(folder)
        for name in ("000999.png", "1000999.png", "my.png", "00999.png", "000999.png.txt"):
            open(os.path.join(folder, name), "w", encoding="ascii").close()
        self.results()
        self.assertEqual(len(os.listdir(folder)), 5, "not asked for overlays")
        self.results("--overlays", "1000")
        kept = sorted(os.listdir(folder))
        self.assertEqual(kept[1:], ["000999.png.txt", "00999.png", "my.png"])

    def test_overlays_of_every_third_used_frame(self):
        write_bag(self.bag, info=True)
        result = self.run_it(self.bag, "--out", self.out, self.pose, "--overlays", "3")
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(os.path.join(self.out, "obstacles.csv"), encoding="ascii") as file:
            used = sorted({int(row["frame"]) for row in csv.DictReader(file)})
        wanted = ["%06d.png" % frame for frame in used[::3]]
        self.assertGreater(len(wanted), 1)
        folder = os.path.join(self.out, "overlays")
        self.assertEqual(sorted(os.listdir(folder)), wanted)
        pictures = {open(os.path.join(folder, name), "rb").read() for name in wanted}
        self.assertEqual(len(pictures), len(wanted), "each shows a frame of its own")
        for wrong in ("0", "-3", "x", "inf"):
            self.refused(2, "--overlays: has to be a number above 0, not '%s'\n" % wrong, self.bag,
                         "--out", self.out, "--overlays", wrong)

    def test_trajectory_has_every_frame_by_wheels_and_by_floor(self):
        write_bag(self.bag, info=True, frames=20)
        result = self.run_it(self.bag, "--out", self.out, self.pose)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(os.path.join(self.out, "trajectory.csv"), encoding="ascii") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0]), (
            "stamp frame x_odom y_odom theta_odom x_refined y_refined theta_refined "
            "var_x cov_xy cov_xtheta var_y cov_ytheta var_theta").split())
        self.assertEqual([int(row["frame"]) for row in rows], list(range(20)))
        for k, row in enumerate(rows):
            self.assertAlmostEqual(float(row["stamp"]), 1000.0 + 0.1 * k, 6)
            self.assertAlmostEqual(float(row["x_odom"]), 0.025 * k, 5)
        self.assertLess(abs(float(rows[-1]["x_refined"]) - 0.475), 0.005)
        self.assertGreater(float(rows[-1]["var_x"]), 0.0)

    def test_refined_poses_place_contacts_where_the_trajectory_is(self):
        write_bag(self.bag, info=True, frames=20, wheels=1.05)
        wrong = {}
        for poses in ("odometry", "refined"):
            result = self.run_it(self.bag, "--out", self.out, self.pose,
                                 "--set", "floor_odometry/poses=" + poses)
            self.assertEqual(result.returncode, 0, result.stderr)
            with open(os.path.join(self.out, "points.csv"), encoding="ascii") as file:
                places = sorted(abs(float(row["x_odom"]) - 1.6) for row in csv.DictReader(file)
                                if int(row["frame"]) >= 16)
            wrong[poses] = places[len(places) // 2]
        self.assertLess(wrong["refined"], 0.5 * wrong["odometry"])

    def test_temporal_filter_keeps_some_contacts_of_the_same_frames(self):
        write_bag(self.bag, info=True, frames=20)
        tables = {}
        for name, options in (("plain", []), ("filtered", ["--temporal-filter"])):
            out = os.path.join(self.folder.name, name)
            result = self.run_it(self.bag, "--out", out, self.pose, *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            with open(os.path.join(out, "points.csv"), encoding="ascii") as file:
                tables[name] = set(file.readlines()[1:])
            with open(os.path.join(out, "obstacles.csv"), encoding="ascii") as file:
                tables[name + " frames"] = {line.split(",")[1] for line in file}
        self.assertEqual(tables["plain frames"], tables["filtered frames"])
        self.assertTrue(tables["filtered"])
        self.assertTrue(tables["filtered"] < tables["plain"], "the first frame has no second sight")

    def test_every_instruction_set_gives_the_same_tables(self):
        write_bag(self.bag, info=True, frames=20)
        self.refused(2, "no instruction set 'MMX'", self.bag, "--out", self.out, "--simd", "MMX")
        known = self.run_it(self.bag, "--out", self.out, "--simd", "MMX").stderr
        names = known.split("there are ")[1].split("\n")[0].split(", ")
        tables = set()
        for name in names:
            result = self.run_it(self.bag, "--out", self.out, self.pose, "--simd", name.lower())
            self.assertEqual(result.returncode, 0, result.stderr)
            with open(os.path.join(self.out, "report.json"), encoding="utf-8") as file:
                self.assertEqual(json.load(file)["simd"], name)
            tables.add(tuple(open(os.path.join(self.out, table), encoding="ascii").read()
                             for table in ("points.csv", "obstacles.csv", "trajectory.csv")))
        self.assertEqual(len(tables), 1, names)

    def test_a_robot_that_stands_is_no_error(self):
        write_bag(self.bag, info=True, way=standing)
        result = self.run_it(self.bag, "--out", self.out, self.pose)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(os.path.join(self.out, "report.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["frames"]["used"], 0)

    def test_a_robot_that_stops_looks_on_which_is_nothing_for_map_and_tables(self):
        write_bag(self.bag, info=True, frames=30, way=lambda t: min(0.25 * t, 0.45))
        maps, frames = [], []
        for options in ([], ["--standing"], ["--set", "sweep/watch=0"]):
            result = self.run_it(self.bag, "--out", self.out, self.pose, *options)
            self.assertEqual(result.returncode, 0, result.stderr)
            with open(os.path.join(self.out, "report.json"), encoding="utf-8") as file:
                counted = json.load(file)["frames"]
            maps.append(open(os.path.join(self.out, "map.pgm"), "rb").read())
            with open(os.path.join(self.out, "obstacles.csv"), encoding="ascii") as file:
                frames.append(sorted({int(row["frame"]) for row in csv.DictReader(file)}))
            reason = "no_motion" if "sweep/watch=0" in options else "watched"
            self.assertEqual(counted["skipped"][reason], 11 if reason == "no_motion" else 9)
        self.assertEqual(len(set(maps)), 1)
        self.assertEqual(frames[0], frames[2])
        self.assertEqual(frames[0][-1], 18)
        self.assertEqual(frames[1], frames[0] + list(range(21, 30)), "it stands from then on")

    def test_what_was_not_confirmed_is_not_while_the_robot_stands(self):
        write_bag(self.bag, info=True, frames=40, way=lambda t: min(0.25 * t, 0.45))
        result = self.run_it(self.bag, "--out", self.out, self.pose, "--standing",
                             "--temporal-filter", "--set", "memory/confirm_frames=16",
                             "--set", "memory/confirm_of=16")
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(os.path.join(self.out, "obstacles.csv"), encoding="ascii") as file:
            self.assertIn("39", {row["frame"] for row in csv.DictReader(file)})
        with open(os.path.join(self.out, "points.csv"), encoding="ascii") as file:
            self.assertEqual(len(file.readlines()), 1)

    def test_wrong_usage_exits_with_2(self):
        self.refused(2, "--out", self.bag)
        self.refused(2, "profile", self.bag, "--out", self.out, "--profile", "nonsense")
        self.refused(2, "map/resolution", self.bag, "--out", self.out, "--set", "map/resolution=-1")
        self.refused(2, "no parameter 'map/x'", self.bag, "--out", self.out, "--set", "map/x=1")

    def test_a_camera_pose_that_no_robot_has_is_wrong_usage(self):
        write_bag(self.bag, info=True)
        for pose, words in (("0,0,0.4,24", "camera/pitch = 24 rad: allowed is -1.5 ... 1.5"),
                            ("0,0,-0.3,0.2", "camera/z = -0.3 m: allowed is"),
                            ("0,0,40,0.2", "camera/z = 40 m"), ("0,nan,0.4,0.2", "camera/y = nan")):
            self.refused(2, "--camera-pose: " + words, self.bag, "--out", self.out,
                         "--camera-pose=" + pose)

    def test_unreadable_inputs_exit_with_3_and_one_line(self):
        self.refused(3, "cannot read bag", "/nowhere.bag", "--out", self.out)
        with open(self.bag, "w", encoding="ascii") as file:
            file.write("no bag")
        self.refused(3, "cannot read bag", self.bag, "--out", self.out)
        with rosbag.Bag(self.bag, "w"):
            pass
        self.refused(3, "is empty", self.bag, "--out", self.out)

    def test_missing_topics_are_named(self):
        write_bag(self.bag, images=False)
        self.refused(3, "no image topic", self.bag, "--out", self.out)
        write_bag(self.bag, odometry=False)
        self.refused(3, "no odometry topic", self.bag, "--out", self.out)
        write_bag(self.bag)
        self.refused(3, "/front/image", self.bag, "--out", self.out, "--image-topic", "/front/image")
        self.refused(3, "--camera-info", self.bag, "--out", self.out, self.pose)

    def large_calibration(self):
        path = os.path.join(self.folder.name, "large.yaml")
        with open(path, "w", encoding="ascii") as file:
            file.write(CALIBRATION.replace("image_width: 320", "image_width: 640")
                       .replace("image_height: 240", "image_height: 481"))
        return path

    def test_bad_calibrations_and_pictures_are_named(self):
        write_bag(self.bag, info=True, fx=0.0)
        self.refused(3, "K[0]", self.bag, "--out", self.out, self.pose)
        write_bag(self.bag, info=True, encoding="32FC1")
        self.refused(3, "32FC1", self.bag, "--out", self.out, self.pose)
        write_bag(self.bag, info=True)
        with open(self.calibration, "w", encoding="ascii") as file:
            file.write(CALIBRATION.replace("image_width: 320", "image_width: 640"))
        self.refused(3, "image of 640 x 481: the datapath holds up to 640 x 480", self.bag, "--out",
                     self.out, "--camera-info", self.large_calibration(), self.pose, "--fpga")
        self.refused(3, "calibrated size", self.bag, "--out", self.out, "--camera-info",
                     self.calibration, self.pose)


if __name__ == "__main__":
    unittest.main(verbosity=2)
