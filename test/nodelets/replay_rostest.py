#!/usr/bin/python3
"""A bag played through replay.launch gives the map that offline_mapper makes of it, cell for cell."""

import os
import shutil
import subprocess
import tempfile
import time
import unittest

import rospy
import rostest
from ipm_mapping.msg import ObstacleArray
from ipm_mapping.srv import SaveMap
from nav_msgs.msg import OccupancyGrid

FRAMES = 40
QUEUE = 1000  # nothing may be dropped, however slow the machine


def tool(name, *arguments):
    return subprocess.run(["rosrun", "ipm_mapping", name, *arguments], check=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=200)


def package_file(*parts):
    return os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", *parts)


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="ipm_mapping_replay_")
        cls.bag = os.path.join(cls.folder, "short.bag")
        tool("sim_to_bag", package_file("sim", "scenes", "sample.yaml"), cls.bag,
             "--frames", str(FRAMES), "--set", "camera.width=320", "--set", "camera.height=240",
             "--set", "camera.fx=262.5", "--set", "camera.fy=262.5",
             "--set", "camera.cx=159.5", "--set", "camera.cy=119.5")

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def offline(self, profile):
        out = os.path.join(self.folder, "offline_" + profile)
        tool("offline_mapper", self.bag, "--out", out, "--profile", profile)
        with open(os.path.join(out, "obstacles.csv"), encoding="ascii") as table:
            frames = {line.split(",")[1] for line in table.readlines()[1:]}
        return os.path.join(out, "map"), len(frames)

    def live(self, profile, expected_frames):
        """Plays the bag; returns the saved map's path without its ending."""
        name = "replay_" + profile
        answers = []
        rospy.Subscriber("/%s/obstacles" % name, ObstacleArray, answers.append, queue_size=QUEUE)
        first = "ipm" if profile == "paper" else "detector"
        for parameter, value in (("queue", QUEUE), ("waiting_frames", QUEUE), ("odometry/wait", 60.0)):
            rospy.set_param("/%s/%s/%s" % (name, first, parameter), value)
        for nodelet in ("segmentation", "localization", "mapper"):
            rospy.set_param("/%s/%s/queue" % (name, nodelet), QUEUE)
        launch = subprocess.Popen(
            ["roslaunch", "ipm_mapping", "replay.launch", "bag:=" + self.bag, "rviz:=false",
             "namespace:=" + name, "profile:=" + profile, "map_directory:=" + self.folder,
             "rate:=0.5", "delay:=6"], stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT)
        try:
            self.wait(lambda: len(answers) >= expected_frames, 90)
            rospy.wait_for_service("/%s/save_map" % name, 30)
            newest = answers[-1].header.stamp
            grid = []
            rospy.Subscriber("/%s/map" % name, OccupancyGrid, grid.append)
            self.wait(lambda: grid and grid[-1].header.stamp >= newest, 30)
            saved = rospy.ServiceProxy("/%s/save_map" % name, SaveMap)("live_" + profile)
            self.assertTrue(saved.success, saved.message)
            self.assertEqual(len(answers), expected_frames)
            return os.path.splitext(saved.message)[0]
        finally:
            launch.terminate()
            launch.wait(timeout=60)

    def wait(self, condition, seconds):
        end = time.time() + seconds
        while not condition() and time.time() < end:
            time.sleep(0.1)
        self.assertTrue(condition(), "timed out")

    def compare(self, profile):
        expected, frames = self.offline(profile)
        self.assertGreater(frames, 5)
        got = self.live(profile, frames)
        for ending in (".pgm", ".yaml"):
            with open(expected + ending, "rb") as a, open(got + ending, "rb") as b:
                theirs, ours = a.read(), b.read()
            if ending == ".yaml":  # only the picture's name may differ
                theirs, ours = (text.split(b"\n", 1)[1] for text in (theirs, ours))
            self.assertEqual(theirs, ours, ending)
        with open(expected + ".pgm", "rb") as picture:
            values = set(picture.read().split(b"\n", 3)[-1])
        self.assertGreater(len(values), 1, "the map has to say something")

    def test_default_profile(self):
        self.compare("default")

    def test_paper_profile(self):
        self.compare("paper")


if __name__ == "__main__":
    rospy.init_node("replay_rostest", disable_rostime=True)
    rostest.rosrun("ipm_mapping", "replay_rostest", Replay)
