#!/usr/bin/python3
"""The simulated robot as a user meets it: what it publishes, and that it does what it is told.

Nothing is said about time: waiting goes on until something has happened, or fails after a minute.
"""
import math
import unittest

import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import CameraInfo, Image

BOX_FRONT, RADIUS = 1.0, 0.18  # simulated_robot.yaml; the body's default
ODOMETRY_SCALE = 1.1
PATIENCE = 60.0


def heading(message):
    q = message.pose.pose.orientation
    return 2 * math.atan2(q.z, q.w)


class SimulatedRobotTest(unittest.TestCase):
    topics = {"image": ("camera/rgb/image_raw", Image),
              "camera_info": ("camera/rgb/camera_info", CameraInfo),
              "odom": ("odom", Odometry), "truth": ("ground_truth/odom", Odometry),
              "map": ("ground_truth/map", OccupancyGrid),
              "diagnostics": ("/diagnostics", DiagnosticArray)}

    @classmethod
    def setUpClass(cls):
        rospy.init_node("simulated_robot_rostest")
        cls.seen = {name: [] for name in cls.topics}
        cls.tf = tf2_ros.Buffer(rospy.Duration(300))
        cls.listeners = [tf2_ros.TransformListener(cls.tf)] + [
            rospy.Subscriber(topic, kind, cls.seen[name].append)
            for name, (topic, kind) in cls.topics.items()]
        cls.commands = rospy.Publisher("cmd_vel", Twist, queue_size=1)

    def wait(self, done, what, v=None, w=0.0):
        """Until done() holds; commands the robot meanwhile if v is given."""
        end = rospy.get_time() + PATIENCE
        while not done():
            self.assertLess(rospy.get_time(), end, f"waited in vain: {what}")
            if v is not None:
                command = Twist()
                command.linear.x, command.angular.z = v, w
                self.commands.publish(command)
            rospy.sleep(0.05)

    def pairs(self):
        infos = {info.header.stamp: info for info in self.seen["camera_info"]}
        return [(image, infos[image.header.stamp]) for image in self.seen["image"]
                if image.header.stamp in infos]

    def x(self):
        return self.seen["truth"][-1].pose.pose.position.x

    def test_1_everything_is_published(self):
        self.wait(lambda: all(self.seen.values()), "a message of every topic")
        # The two topics connect one after the other: the first message of one may lack the other.
        self.wait(self.pairs, "an image and its camera_info, with one stamp")
        image, info = self.pairs()[0]
        self.assertEqual((image.width, image.height, image.encoding), (160, 120, "mono8"))
        self.assertEqual(image.header.frame_id, info.header.frame_id)
        self.assertEqual([info.K[0], info.K[2], info.K[4], info.K[5]], [131, 79.5, 131, 59.5])
        self.assertGreater(max(image.data) - min(image.data), 40, "a picture of one grey")

    def test_2_the_camera_stands_where_the_scene_says(self):
        frame = "camera_rgb_optical_frame"
        self.wait(lambda: self.tf.can_transform("base_footprint", frame, rospy.Time()), "tf")
        there = self.tf.lookup_transform("base_footprint", frame, rospy.Time()).transform
        for value, stated in zip((there.translation.x, there.translation.y, there.translation.z),
                                 (0.06, -0.01, 0.4)):
            self.assertAlmostEqual(value, stated, places=6)
        q = there.rotation
        up = 1 - 2 * (q.x ** 2 + q.y ** 2)  # of the optical axis
        self.assertAlmostEqual(up, -math.sin(0.4), places=6)

    def test_3_the_true_map_has_the_box_and_nothing_before_it(self):
        self.wait(lambda: self.seen["map"], "the true map")
        grid = self.seen["map"][0]

        def cell(x, y):
            column = int((x - grid.info.origin.position.x) / grid.info.resolution)
            row = int((y - grid.info.origin.position.y) / grid.info.resolution)
            return grid.data[row * grid.info.width + column]
        self.assertEqual(cell(BOX_FRONT + 0.01, 0.0), 100)
        self.assertEqual(cell(BOX_FRONT - 0.15, 0.0), 0)

    def test_4_it_follows_commands_and_stops_when_they_stop(self):
        self.wait(lambda: self.seen["truth"], "the true pose")
        self.assertEqual(self.x(), 0.0, "an empty script must not move the robot")
        self.wait(lambda: self.x() > 0.15, "the robot to drive", v=0.2)
        self.wait(lambda: self.seen["truth"][-1].twist.twist.linear.x == 0.0, "the robot to stop")
        stopped, count = self.x(), len(self.seen["truth"])
        self.wait(lambda: len(self.seen["truth"]) > count + 20, "twenty more poses")
        self.assertEqual(self.x(), stopped)
        self.assertLess(stopped, BOX_FRONT - RADIUS - 0.05, "it did not stop by itself")

    def test_5_odometry_has_the_scene_s_error_and_tf_says_the_same(self):
        odometry = {m.header.stamp: m for m in self.seen["odom"]}
        true = [m for m in self.seen["truth"] if m.header.stamp in odometry]
        self.assertGreater(true[-1].pose.pose.position.x, 0.1)
        for m in true:
            self.assertAlmostEqual(odometry[m.header.stamp].pose.pose.position.x,
                                   ODOMETRY_SCALE * m.pose.pose.position.x, delta=0.01)
        last = self.seen["odom"][-1]
        place = (last.header.frame_id, last.child_frame_id, last.header.stamp)
        self.wait(lambda: self.tf.can_transform(*place), "tf of the last odometry")
        self.assertAlmostEqual(self.tf.lookup_transform(*place).transform.translation.x,
                               last.pose.pose.position.x, places=9)

    def test_6_it_stops_at_the_box_however_long_it_is_told_to_go_on(self):
        limit = BOX_FRONT - RADIUS
        self.wait(lambda: self.x() > limit - 0.02, "the robot at the box", v=0.3)
        count = len(self.seen["truth"])
        self.wait(lambda: len(self.seen["truth"]) > count + 40, "forty more poses", v=0.3)
        self.assertLessEqual(max(m.pose.pose.position.x for m in self.seen["truth"]), limit + 1e-6)

    def test_7_it_turns_on_the_spot(self):
        before = self.x()
        self.wait(lambda: heading(self.seen["truth"][-1]) > 0.3, "the robot to turn", v=0.0, w=0.5)
        self.assertAlmostEqual(self.x(), before, delta=0.02)

    def test_8_pictures_go_on_and_show_that_the_robot_has_moved(self):
        count = len(self.seen["image"])
        self.wait(lambda: len(self.seen["image"]) > count + 1, "two more pictures")
        stamps = [m.header.stamp for m in self.seen["image"]]
        self.assertEqual(stamps, sorted(set(stamps)))
        first, last = self.seen["image"][0].data, self.seen["image"][-1].data
        different = sum(abs(a - b) > 15 for a, b in zip(first, last))
        self.assertGreater(different, 0.2 * len(first))

    def test_9_the_detector_beside_it_works_and_lost_no_frame(self):
        def counters():
            values = [(each.key, each.value) for array in self.seen["diagnostics"]
                      for status in array.status if "detector" in status.name
                      for each in status.values]
            return dict(values)  # the latest of each
        self.wait(lambda: int(counters().get("received", 0)) > 10, "frames to be taken")
        dropped = {key: value for key, value in counters().items() if key.startswith("dropped_")}
        self.assertEqual(dropped, {})


if __name__ == "__main__":
    import rostest
    rostest.rosrun("ipm_mapping", "simulated_robot_rostest", SimulatedRobotTest)
