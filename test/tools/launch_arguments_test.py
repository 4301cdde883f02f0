#!/usr/bin/python3
"""What `roslaunch --ros-args` says about every launch file: each argument is explained, with unit and
default, and only what a user has to give is called required.

launch_arguments_test.py FOLDER_OF_LAUNCH_FILES
"""

import glob
import os
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

import yaml

FOLDER = sys.argv.pop(1)
REQUIRED = {"replay.launch": {"bag"}}
# Of the arguments that are passed on to chain.launch, those with a default of their own.
OWN_DEFAULT = {"replay.launch": {"rviz"},
               "move_base.launch": {"base_frame", "odom_frame", "global_frame"}}
UNIT = re.compile(r"\b(m|rad|seconds|times|grey levels)\b")


def launch_files():
    return sorted(glob.glob(os.path.join(FOLDER, "*.launch")))


def arguments(path):
    """Of the file itself: name -> attributes. Those with a value are made from others."""
    found = [each.attrib for each in ElementTree.parse(path).getroot().findall("arg")]
    return {each["name"]: each for each in found}


def passes_everything_to_the_chain(path):
    return any(each.get("file", "").endswith("/chain.launch") and each.get("pass_all_args") == "true"
               for each in ElementTree.parse(path).getroot().iter("include"))


def is_number(text):
    try:
        float(text)
    except ValueError:
        return False
    return True


def parameters(name, *values):
    """What a launch file sets, by full name."""
    text = subprocess.run(
        ["roslaunch", "--dump-params", os.path.join(FOLDER, name + ".launch"), *values],
        check=True, timeout=60, stdout=subprocess.PIPE, universal_newlines=True).stdout
    return yaml.safe_load(text)


class LaunchArguments(unittest.TestCase):
    def test_there_are_launch_files(self):
        self.assertGreaterEqual(len(launch_files()), 5)

    def test_every_argument_is_explained_and_no_other(self):
        for path in launch_files():
            for name, attributes in arguments(path).items():
                where = "%s: %s" % (os.path.basename(path), name)
                doc = attributes.get("doc", "")
                if "value" in attributes:  # roslaunch would call it required
                    self.assertEqual(doc, "", where)
                else:
                    self.assertGreater(len(doc.split()), 2, where)

    def test_numbers_have_a_unit(self):
        for path in launch_files():
            for name, attributes in arguments(path).items():
                if is_number(attributes.get("default", "")):
                    self.assertRegex(attributes["doc"], UNIT,
                                     "%s: %s" % (os.path.basename(path), name))

    def test_a_word_for_nothing_is_explained(self):
        for path in launch_files():
            for name, attributes in arguments(path).items():
                for word in ("none", "auto", "true", "false"):
                    if attributes.get("default") == word:
                        self.assertIn(word if word in ("none", "auto") else "true",
                                      attributes["doc"], "%s: %s" % (os.path.basename(path), name))

    def test_what_is_passed_on_is_all_of_the_chain(self):
        chain = arguments(os.path.join(FOLDER, "chain.launch"))
        passing = [path for path in launch_files() if passes_everything_to_the_chain(path)]
        self.assertEqual([os.path.basename(path) for path in passing],
                         ["move_base.launch", "replay.launch"])
        for path in passing:
            name, own = os.path.basename(path), arguments(path)
            settable = {each for each in chain if "value" not in chain[each]}
            self.assertLessEqual(settable, set(own), name)
            other = {each for each in settable if own[each]["default"] != chain[each]["default"]}
            self.assertEqual(other, OWN_DEFAULT[name], name)

    def test_values_arrive_at_every_nodelet_that_uses_them(self):
        given = {"image_time_offset": -0.25, "autosave_period": 7.5, "clear_on_clock_jump": True}
        first = {"sweep": "detector", "chain": "ipm", "first_architecture": "ipm"}
        for name, more in (("chain", []), ("move_base", []), ("replay", ["bag:=drive.bag"])):
            for detector, nodelet in first.items():
                found = parameters(name, "detector:=" + detector, *more,
                                   *("%s:=%s" % each for each in given.items()))
                self.assertEqual(found["/camera/%s/camera/image_time_offset" % nodelet],
                                 given["image_time_offset"], (name, detector))
                for each in ("autosave_period", "clear_on_clock_jump"):
                    self.assertEqual(found["/camera/mapper/" + each], given[each], (name, each))
        found = parameters("compare", "image_time_offset:=-0.25")
        for nodelet in ("ipm", "fpga_model"):
            self.assertEqual(found["/camera/%s/camera/image_time_offset" % nodelet], -0.25, nodelet)

    def test_the_floor_is_the_localiser_only_where_it_is_asked(self):
        for name, more in (("chain", []), ("move_base", []), ("replay", ["bag:=drive.bag"])):
            found = parameters(name, *more)
            self.assertNotIn("/camera/detector/map_frame", found, name)
            self.assertEqual(found["/camera/mapper/global_frame"], "", name)
            for given, frame in (([], "map"), (["global_frame:=world"], "world")):
                found = parameters(name, "floor_localiser:=true", *given, *more)
                self.assertEqual(found["/camera/detector/map_frame"], frame, name)
                self.assertEqual(found["/camera/mapper/global_frame"], frame, name)
                self.assertEqual(found["/camera/mapper/correction"], "keep", name)
                if name == "move_base":
                    self.assertEqual(found["/move_base/global_costmap/global_frame"], frame)
        found = parameters("chain", "detector:=chain", "floor_localiser:=true")
        self.assertNotIn("/camera/ipm/map_frame", found)
        self.assertEqual(found["/camera/mapper/global_frame"], "", "nobody would publish it")

    def test_further_settings_arrive_at_the_nodelets_that_they_name(self):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write("mapper: {publish_rate: 2.5}\ndetector: {queue: 40}\n")
            file.flush()
            for name, more in (("chain", []), ("move_base", []), ("replay", ["bag:=drive.bag"])):
                found = parameters(name, "namespace:=left", "settings:=" + file.name, *more)
                self.assertEqual(found["/left/mapper/publish_rate"], 2.5, name)
                self.assertEqual(found["/left/detector/queue"], 40, name)
                self.assertEqual(found["/left/mapper/correction"], "follow", name)

    def test_every_namespace_has_a_folder_of_its_own_for_its_maps(self):
        folder = lambda *values: parameters("chain", *values)["/%s/mapper/directory" % (
            values[0].partition(":=")[2] if values else "camera")]
        self.assertEqual(folder(), "~/.ros/ipm_mapping")
        self.assertEqual(folder("namespace:=rear"), "~/.ros/ipm_mapping/rear")
        self.assertEqual(folder("namespace:=rear", "map_directory:=/maps"), "/maps")

    def test_bags_are_named_as_the_shell_sees_them(self):
        for name in ("replay", "compare"):
            for given, played in (("drive.bag", os.path.join(os.environ["PWD"], "drive.bag")),
                                  ("/data/drive.bag", "/data/drive.bag")):
                text = subprocess.run(
                    ["roslaunch", "--args", "player", os.path.join(FOLDER, name + ".launch"),
                     "bag:=" + given],
                    check=True, timeout=60, stdout=subprocess.PIPE, universal_newlines=True).stdout
                self.assertIn(" %s " % played, text + " ", name)

    CAMERA = {"pose_from_tf": False, "x": 0.11, "y": -0.02, "z": 0.33, "pitch": 0.31}

    def test_the_camera_arrives_at_the_nodelets_that_see(self):
        given = ["%s%s:=%s" % ("" if name == "pose_from_tf" else "camera_", name, value)
                 for name, value in self.CAMERA.items()]
        for name, nodelets in (("chain", ["detector"]), ("compare", ["ipm", "fpga_model"])):
            found = parameters(name, *given, "calibration:=camera.yaml")
            for nodelet in nodelets:
                for each, value in {**self.CAMERA, "calibration_file": "camera.yaml"}.items():
                    self.assertEqual(found["/camera/%s/camera/%s" % (nodelet, each)], value, nodelet)

    def test_what_is_not_given_is_left_to_the_profile(self):
        for name in ("chain", "compare"):
            self.assertFalse([each for each in parameters(name)
                              if re.search("/camera/(image_time_offset|calibration_file|%s)$"
                                           % "|".join(self.CAMERA), each)])

    def test_what_an_earlier_launch_gave_is_forgotten(self):
        for path in launch_files():
            for node in ElementTree.parse(path).getroot().iter("node"):
                if any("unless" in each.attrib for each in node.iter("param")):
                    self.assertEqual(node.get("clear_params"), "true", node.get("name"))

    def test_roslaunch_lists_them_all(self):
        for path in launch_files():
            text = subprocess.run(["roslaunch", "--ros-args", path], check=True, timeout=60,
                                  stdout=subprocess.PIPE, universal_newlines=True).stdout
            required = text.partition("Optional Arguments:")[0]
            listed = set(re.findall(r"^  (\w+)[: ]", text, re.MULTILINE))
            own = {n for n, each in arguments(path).items() if "value" not in each}
            self.assertEqual(listed, own, path)
            self.assertEqual(set(re.findall(r"^  (\w+):", required, re.MULTILINE)),
                             REQUIRED.get(os.path.basename(path), set()), path)


if __name__ == "__main__":
    unittest.main()
