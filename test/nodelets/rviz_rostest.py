#!/usr/bin/python3
"""Every display of rviz/*.rviz is one that rviz has, and shows a topic that the nodelets which are
started with it advertise, with a type that the display takes. No display and no rviz needed."""

import glob
import os
import shlex
import subprocess
import unittest
import xml.etree.ElementTree as ElementTree

import roslaunch.config
import rosgraph.names
import rospkg
import rospy
import rostest
import yaml

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
# namespace -> launch file and arguments
LAUNCHED = {"piece": ("chain.launch", []),
            "chain": ("chain.launch", ["detector:=chain"]),
            "first": ("chain.launch", ["profile:=first_architecture"]),
            "both": ("compare.launch", [])}
# Of rviz 1.14, for machines without it: class -> base class and types of the messages it shows.
CLASSES = {"rviz/Axes": ("Display", []),
           "rviz/Grid": ("Display", []),
           "rviz/Image": ("Display", ["sensor_msgs/CompressedImage", "sensor_msgs/Image",
                                      "theora_image_transport/Packet"]),
           "rviz/LaserScan": ("Display", ["sensor_msgs/LaserScan"]),
           "rviz/Map": ("Display", ["nav_msgs/OccupancyGrid"]),
           "rviz/Path": ("Display", ["nav_msgs/Path"]),
           "rviz/PointCloud2": ("Display", ["sensor_msgs/PointCloud2"]),
           "rviz/TF": ("Display", []),
           "rviz/Measure": ("Tool", []),
           "rviz/MoveCamera": ("Tool", []),
           "rviz/SetGoal": ("Tool", []),
           "rviz/TopDownOrtho": ("ViewController", [])}


def installed_classes():
    """The same of the rviz that is there; nothing without one."""
    try:
        path = os.path.join(rospkg.RosPack().get_path("rviz"), "plugin_description.xml")
    except rospkg.ResourceNotFound:
        return {}
    return {each.get("name"): (each.get("base_class_type").rpartition("::")[2],
                               sorted(t.text for t in each.findall("message_type")))
            for each in ElementTree.parse(path).getroot().iter("class")}


def arguments(namespace, rviz):
    file, given = LAUNCHED[namespace]
    return (os.path.join(PACKAGE, "launch", file),
            given + ["namespace:=" + namespace, "rviz:=" + rviz])


def rviz_node(namespace):
    """Its full name and the configuration that it is started with."""
    config = roslaunch.config.load_config_default([arguments(namespace, "true")], None)
    node, = [each for each in config.nodes if each.type == "rviz"]
    options = shlex.split(node.args)
    return node.namespace + node.name, os.path.realpath(options[options.index("-d") + 1])


def manager(path):
    with open(path, encoding="utf-8") as file:
        return yaml.safe_load(file)["Visualization Manager"]


def shown(display):
    """Every topic that a display names."""
    return [value for key, value in display.items() if key.endswith("Topic") and value]


class RvizConfigurations(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.classes = installed_classes() or CLASSES
        cls.started = []
        for namespace in LAUNCHED:
            file, given = arguments(namespace, "false")
            cls.started.append(subprocess.Popen(["roslaunch", file, *given],
                                                stdout=subprocess.DEVNULL))

    @classmethod
    def tearDownClass(cls):
        for process in cls.started:
            process.terminate()
        for process in cls.started:
            process.wait(timeout=60)

    @staticmethod
    def files():
        return sorted(os.path.realpath(p) for p in glob.glob(os.path.join(PACKAGE, "rviz", "*.rviz")))

    def test_every_configuration_is_started_by_a_launch_file(self):
        self.assertEqual(sorted({rviz_node(each)[1] for each in LAUNCHED}), self.files())

    def test_classes_are_those_of_rviz(self):
        for path in self.files():
            config = manager(path)
            views = [config["Views"]["Current"]] + (config["Views"].get("Saved") or [])
            for kind, entries in (("Display", config["Displays"]), ("Tool", config["Tools"]),
                                  ("ViewController", views)):
                for each in entries:
                    self.assertIn(each["Class"], self.classes, path)
                    self.assertEqual(self.classes[each["Class"]][0], kind, path)

    def test_what_is_noted_here_about_rviz_is_true(self):
        installed = installed_classes()
        if not installed:
            self.skipTest("rviz is not installed")
        self.assertEqual({name: installed.get(name) for name in CLASSES}, CLASSES)

    def test_topics_are_advertised_with_the_right_type(self):
        master = rospy.get_master()
        for namespace in LAUNCHED:
            node, path = rviz_node(namespace)
            wanted = {rosgraph.names.resolve_name(topic, node): self.classes[each["Class"]][1]
                      for each in manager(path)["Displays"] for topic in shown(each)}
            self.assertGreater(len(wanted), 5, path)
            advertised = {}
            for _ in range(1200):
                advertised = dict(master.getPublishedTopics("/" + namespace)[2])
                if set(wanted) <= set(advertised):
                    break
                rospy.rostime.wallsleep(0.05)
            for topic, types in wanted.items():
                self.assertIn(topic, advertised, path)
                self.assertIn(advertised[topic], types, "%s: %s" % (path, topic))


if __name__ == "__main__":
    rospy.init_node("rviz_rostest", disable_rostime=True)
    rostest.rosrun("ipm_mapping", "rviz_rostest", RvizConfigurations)
