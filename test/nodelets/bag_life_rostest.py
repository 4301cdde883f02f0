#!/usr/bin/python3
"""What users do with rosbag play, on running nodelets: pause, start in the middle, five times the
speed, a loop. Every frame that offline_mapper uses is answered, with the same result."""

import csv
import os
import shutil
import subprocess
import tempfile
import time
import unittest
from collections import Counter

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from ipm_mapping.msg import ObstacleArray, ObstacleBearing
from nav_msgs.msg import OccupancyGrid
from std_srvs.srv import SetBool

FRAMES = 40
QUEUE = 1000


def tool(name, *arguments):
    subprocess.run(["rosrun", "ipm_mapping", name, *arguments], check=True,
                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=200)


def wait_for(done, seconds=60.0):
    """Wall time: the bag's clock stands still now and then."""
    end = time.time() + seconds
    while not done():
        if time.time() > end:
            return False
        time.sleep(0.05)
    return True


class Player:
    """rosbag play, which begins when somebody listens to every topic."""

    def __init__(self, bag, *options):
        self.process = subprocess.Popen(
            ["rosbag", "play", "--clock", "--quiet", "--wait-for-subscribers", *options, bag,
             "__name:=player"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)

    @staticmethod
    def pause(paused):
        assert rospy.ServiceProxy("/player/pause_playback", SetBool)(paused).success

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait(timeout=30)


class BagLife(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="ipm_mapping_bag_life_")
        cls.bag = os.path.join(cls.folder, "drive.bag")
        scene = os.path.join(os.path.dirname(os.path.abspath(__file__)),
                             "..", "..", "sim", "scenes", "sample.yaml")
        tool("sim_to_bag", scene, cls.bag, "--frames", str(FRAMES),
             "--set", "camera.width=320", "--set", "camera.height=240", "--set", "camera.fx=262.5",
             "--set", "camera.fy=262.5", "--set", "camera.cx=159.5", "--set", "camera.cy=119.5")
        cls.expected = cls.offline()
        cls.answers, cls.counters, cls.map = [], {}, None
        cls.subscribers = [
            rospy.Subscriber("/camera/obstacles", ObstacleArray,
                             lambda m: cls.answers.append(m), queue_size=QUEUE),
            rospy.Subscriber("/camera/map", OccupancyGrid, cls.keep_map),
            rospy.Subscriber("/diagnostics", DiagnosticArray, cls.keep_counters)]
        assert wait_for(lambda: all(s.get_num_connections() for s in cls.subscribers[:2]))
        assert wait_for(lambda: cls.counters)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    @classmethod
    def offline(cls):
        """Stamp of every used frame -> how many bearings are in each state."""
        out = os.path.join(cls.folder, "offline")
        tool("offline_mapper", cls.bag, "--out", out, "--set", "calibration/learn_shading=false")
        frames = {}
        with open(os.path.join(out, "obstacles.csv"), encoding="ascii") as table:
            for row in csv.DictReader(table):
                frames.setdefault(round(float(row["stamp"]), 4), Counter())[row["state"]] += 1
        return frames

    @classmethod
    def keep_map(cls, message):
        cls.map = message

    @classmethod
    def keep_counters(cls, message):
        for status in message.status:
            if status.name.startswith("camera/detector"):
                cls.counters = {pair.key: pair.value for pair in status.values}

    def setUp(self):
        del self.answers[:]
        self.before = dict(self.counters)

    def more(self, counter):
        return int(self.counters.get(counter, 0)) - int(self.before.get(counter, 0))

    def reported(self, frames):
        """Diagnostics have heard of so many frames."""
        return wait_for(lambda: self.more("received") >= frames)

    @staticmethod
    def stamps(answers):
        return [round(each.header.stamp.to_sec(), 4) for each in answers]

    def assert_as_offline(self, answers):
        names = {getattr(ObstacleBearing, state.upper()): state
                 for state in ("unknown", "free", "occupied", "blocked")}
        self.assertEqual(self.stamps(answers), sorted(self.expected))
        for stamp, answer in zip(self.stamps(answers), answers):
            self.assertEqual(Counter(names[b.state] for b in answer.bearings),
                             self.expected[stamp], "frame %d" % answer.frame)

    def assert_nothing_dropped(self):
        dropped = {name: self.more(name) for name in self.counters if name.startswith("dropped")}
        self.assertEqual({name: n for name, n in dropped.items() if n}, {})

    def test_1_from_the_middle(self):
        start = 1.5
        with Player(self.bag, "--start=%s" % start):
            last = max(self.expected)
            self.assertTrue(wait_for(lambda: last in self.stamps(self.answers)))
            self.assertTrue(wait_for(
                lambda: self.map and round(self.map.header.stamp.to_sec(), 4) == last))
        stamps = self.stamps(self.answers)
        self.assertGreater(min(stamps), min(self.expected) + start / 2)
        self.assertLessEqual(set(stamps), set(self.expected))
        self.assertGreater(len(stamps), 10)
        # The camera's pose in tf was said once, before the start, and is known all the same.
        self.assertAlmostEqual(self.answers[0].view.camera[11], 0.42, places=5)
        self.assertTrue(self.reported(len(stamps)))
        self.assert_nothing_dropped()

    def test_2_paused_at_first_and_in_between(self):
        with Player(self.bag, "--pause", "--rate=0.5") as player:
            rospy.wait_for_service("/player/pause_playback", 30)
            time.sleep(1.5)
            self.assertEqual(self.answers, [], "it is paused")
            player.pause(False)
            self.assertTrue(wait_for(lambda: len(self.answers) >= len(self.expected) // 3))
            player.pause(True)
            time.sleep(3.0)  # longer than odometry may stand still
            paused = len(self.answers)
            self.assertLess(paused, len(self.expected))
            player.pause(False)
            self.assertTrue(wait_for(lambda: len(self.answers) >= len(self.expected)))
            self.assertTrue(self.reported(FRAMES))
        self.assert_as_offline(self.answers)
        self.assertEqual(self.more("resets"), 1, "the bag begins before the end of the test before")
        self.assert_nothing_dropped()

    def test_3_five_times_as_fast(self):
        with Player(self.bag, "--rate=5"):
            self.assertTrue(wait_for(lambda: len(self.answers) >= len(self.expected)))
            self.assertTrue(self.reported(FRAMES))
        self.assert_as_offline(self.answers)
        self.assert_nothing_dropped()

    def test_4_in_a_loop(self):
        passes, count = 3, len(self.expected)
        with Player(self.bag, "--loop", "--rate=2"):
            self.assertTrue(wait_for(lambda: len(self.answers) >= passes * count))
            self.assertTrue(self.reported(passes * FRAMES))
            resets = self.more("resets")
        for k in range(passes):
            self.assert_as_offline(self.answers[k * count:(k + 1) * count])
        self.assertIn(resets, (passes, passes + 1), "one a jump, that to the first pass included")
        self.assertGreater(sum(value != -1 for value in self.map.data), 500, "the map is kept")


if __name__ == "__main__":
    rospy.init_node("bag_life_rostest", disable_rostime=True)
    rostest.rosrun("ipm_mapping", "bag_life_rostest", BagLife)
