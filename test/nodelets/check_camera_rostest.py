#!/usr/bin/python3
"""check_camera on live topics: the same answer as from a bag, in bounded time."""

import math
import os
import re
import subprocess
import tempfile
import time
import unittest

import rospy
from sensor_msgs.msg import Image

COMMAND = ["rosrun", "ipm_mapping", "check_camera", "--live"]
TOPICS = ["--image-topic", "/robot/image_raw", "--odom-topic", "/robot/odom"]


class LiveCheck(unittest.TestCase):
    def test_finds_the_pitch_of_the_driving_robot(self):
        with tempfile.TemporaryDirectory() as out:
            command = COMMAND + TOPICS + ["--seconds", "25", "--out", out,
                                          "--camera-pose", "0.05,0,0.45,0.4375"]
            check = subprocess.Popen(command, stdout=subprocess.PIPE, universal_newlines=True)
            rospy.set_param("/listening", True)
            text, _ = check.communicate(timeout=120)
            self.assertEqual(check.returncode, 0, text)
            self.assertIn("stated_pose_from: command line\n", text)
            pitch = float(re.search(r"^pitch_deg: ([\d.]+)", text, re.MULTILINE).group(1))
            self.assertAlmostEqual(pitch, math.degrees(0.42), delta=0.3, msg=text)
            height = float(re.search(r"^height_m: ([\d.]+)", text, re.MULTILINE).group(1))
            self.assertAlmostEqual(height, 0.45, delta=0.01, msg=text)
            self.assertTrue(os.path.exists(os.path.join(out, "camera_check.png")))

    def test_a_silent_robot_ends_in_time_with_one_line(self):
        start = time.monotonic()
        result = subprocess.run(COMMAND + ["--seconds", "2", "--image-topic", "/nobody/image"],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                universal_newlines=True, timeout=60)
        self.assertEqual(result.returncode, 3)
        self.assertIn("no frame came through in 2 s: no image on /nobody/image", result.stderr)
        self.assertLess(time.monotonic() - start, 40.0)

    def test_images_without_odometry_name_both_topics(self):
        images = rospy.Publisher("/lonely/image_raw", Image, queue_size=1)
        def publish(_):
            image = Image(height=48, width=64, encoding="mono8", step=64, data=bytes(48 * 64))
            image.header.stamp, image.header.frame_id = rospy.Time.now(), "camera"
            images.publish(image)
        timer = rospy.Timer(rospy.Duration(0.1), publish)
        result = subprocess.run(COMMAND + ["--seconds", "3", "--image-topic", "/lonely/image_raw",
                                           "--odom-topic", "/nobody/odom"],
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                universal_newlines=True, timeout=60)
        timer.shutdown()
        self.assertEqual(result.returncode, 3)
        self.assertIn("images on /lonely/image_raw, odometry expected on /nobody/odom", result.stderr)


if __name__ == "__main__":
    import rostest
    rospy.init_node("check_camera_rostest")
    rostest.rosrun("ipm_mapping", "check_camera_rostest", LiveCheck)
