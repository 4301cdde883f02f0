#!/usr/bin/python3
"""move_base as move_base.launch would start it: the parameters that arrive at it are ones that it
reads, and its costmaps listen to what the chain publishes. No master and no move_base needed.

move_base_config_test.py FOLDER_OF_THE_PACKAGE
"""

import functools
import glob
import os
import posixpath
import subprocess
import sys
import tempfile
import unittest

import yaml

PACKAGE = sys.argv.pop(1)
LAUNCH = os.path.join(PACKAGE, "launch", "move_base.launch")
IN_A_GROUP = ('<launch><group ns="robot1"><include file="%s" pass_all_args="true">'
              "</include></group></launch>" % LAUNCH)
COSTMAPS = ("global_costmap", "local_costmap")
PLUGINS = [("static_layer", "costmap_2d::StaticLayer"),
           ("obstacle_layer", "costmap_2d::ObstacleLayer"),
           ("inflation_layer", "costmap_2d::InflationLayer")]
# source -> data_type, marking, clearing
SOURCES = {"scan": ("LaserScan", False, True),
           "contacts": ("PointCloud2", True, False),
           "free": ("PointCloud2", False, True)}

# What move_base and its plugins read, in ROS Noetic. A name that is not here has no effect there.
LAYERS = {
    "static_layer": {
        "enabled", "map_topic", "first_map_only", "subscribe_to_updates", "track_unknown_space",
        "use_maximum", "lethal_cost_threshold", "unknown_cost_value", "trinary_costmap"},
    "obstacle_layer": {
        "enabled", "footprint_clearing_enabled", "max_obstacle_height", "combination_method",
        "track_unknown_space", "transform_tolerance", "observation_sources", "obstacle_range",
        "raytrace_range"},
    "inflation_layer": {"enabled", "cost_scaling_factor", "inflation_radius", "inflate_unknown"}}
SOURCE = {
    "topic", "sensor_frame", "observation_persistence", "expected_update_rate", "data_type",
    "min_obstacle_height", "max_obstacle_height", "inf_is_valid", "clearing", "marking",
    "obstacle_range", "raytrace_range"}
COSTMAP = {
    "global_frame", "robot_base_frame", "rolling_window", "track_unknown_space",
    "always_send_full_costmap", "plugins", "footprint_topic", "published_footprint_topic",
    "transform_tolerance", "update_frequency", "publish_frequency", "width", "height", "resolution",
    "origin_x", "origin_y", "footprint", "robot_radius", "footprint_padding"}
RECOVERY = {"reset_distance", "invert_area_to_clear", "force_updating", "affected_maps",
            "layer_names"}
NAVFN = {"allow_unknown", "default_tolerance", "visualize_potential", "planner_window_x",
         "planner_window_y"}
DWA = {
    "max_vel_trans", "min_vel_trans", "max_vel_x", "min_vel_x", "max_vel_y", "min_vel_y",
    "max_vel_theta", "min_vel_theta", "acc_lim_x", "acc_lim_y", "acc_lim_theta", "acc_lim_trans",
    "prune_plan", "xy_goal_tolerance", "yaw_goal_tolerance", "trans_stopped_vel",
    "theta_stopped_vel", "latch_xy_goal_tolerance", "sim_time", "sim_granularity",
    "angular_sim_granularity", "path_distance_bias", "goal_distance_bias", "occdist_scale",
    "twirling_scale", "stop_time_buffer", "oscillation_reset_dist", "oscillation_reset_angle",
    "forward_point_distance", "scaling_speed", "max_scaling_factor", "vx_samples", "vy_samples",
    "vth_samples", "use_dwa", "publish_cost_grid_pc", "publish_traj_pc"}
MOVE_BASE = {
    "base_global_planner", "base_local_planner", "planner_frequency", "controller_frequency",
    "planner_patience", "controller_patience", "max_planning_retries", "oscillation_timeout",
    "oscillation_distance", "conservative_reset_dist", "clearing_radius", "shutdown_costmaps",
    "clearing_rotation_allowed", "recovery_behavior_enabled", "recovery_behaviors",
    "make_plan_clear_costmap", "make_plan_add_unreachable_goal"}


def known_costmap():
    layers = {name: dict.fromkeys(keys) for name, keys in LAYERS.items()}
    layers["obstacle_layer"].update({name: dict.fromkeys(SOURCE) for name in SOURCES})
    return dict(dict.fromkeys(COSTMAP), **layers)


def known_parameters():
    """Name -> None, or the names below it."""
    known = dict.fromkeys(MOVE_BASE)
    known.update({name: known_costmap() for name in COSTMAPS})
    known.update({name: dict.fromkeys(RECOVERY)
                  for name in ("conservative_reset", "aggressive_reset")})
    known.update({"NavfnROS": dict.fromkeys(NAVFN), "DWAPlannerROS": dict.fromkeys(DWA)})
    return known


def unknown_names(parameters, known, where=""):
    """Those that are not in the tree `known`, or a folder there and none here, or the reverse."""
    found = []
    for name, value in parameters.items():
        if name not in known or isinstance(known[name], dict) != isinstance(value, dict):
            found.append(where + name)
        elif isinstance(value, dict):
            found += unknown_names(value, known[name], where + name + "/")
    return found


@functools.lru_cache(None)
def roslaunch(option, launch, *arguments):
    """`launch`: path of a file, or its text."""
    with tempfile.NamedTemporaryFile("w", suffix=".launch") as file:
        if launch.startswith("<"):
            file.write(launch)
            file.flush()
            launch = file.name
        return subprocess.run(("roslaunch", option, launch) + arguments, check=True, timeout=60,
                              stdout=subprocess.PIPE, universal_newlines=True).stdout


def parameters(launch, *arguments):
    """Of everything that is started, full name -> value."""
    return yaml.safe_load(roslaunch("--dump-params", launch, *arguments))


def nodes(launch, *arguments):
    return roslaunch("--nodes", launch, *arguments).split()


def below(namespace, flat):
    """The part of `flat` below a namespace, as a tree."""
    tree = {}
    for name, value in flat.items():
        if name.startswith(namespace + "/"):
            *folders, leaf = name[len(namespace) + 1:].split("/")
            place = tree
            for folder in folders:
                place = place.setdefault(folder, {})
            place[leaf] = value
    return tree


def move_base(*arguments):
    return below("/move_base", parameters(LAUNCH, *arguments))


def layers_of(costmap):
    return [(each["name"], each["type"]) for each in costmap["plugins"]]


def topics(costmap):
    obstacles = costmap["obstacle_layer"]
    return dict({name: obstacles[name]["topic"] for name in SOURCES},
                map=costmap["static_layer"]["map_topic"])


class MoveBaseConfig(unittest.TestCase):
    def setUp(self):
        self.move_base = move_base()
        self.costmaps = {name: self.move_base[name] for name in COSTMAPS}

    @staticmethod
    def defaults():
        with open(os.path.join(PACKAGE, "config", "default.yaml")) as file:
            return yaml.safe_load(file)

    def sources(self):
        for name, costmap in self.costmaps.items():
            for source in costmap["obstacle_layer"]["observation_sources"].split():
                yield "%s: %s" % (name, source), source, costmap["obstacle_layer"][source]

    def test_every_parameter_is_one_that_is_read(self):
        self.assertEqual(unknown_names(self.move_base, known_parameters()), [])

    def test_the_files_hold_what_arrives(self):
        """No key of a file is lost on the way, for instance by a wrong namespace."""
        for path in glob.glob(os.path.join(PACKAGE, "config", "move_base", "*.yaml")):
            with open(path) as file:
                content = yaml.safe_load(file)
            common = os.path.basename(path) == "costmap_common.yaml"
            for costmap in COSTMAPS if common else (None,):
                known = known_costmap() if common else known_parameters()
                self.assertEqual(unknown_names(content, known), [], path)
                arrived = self.move_base[costmap] if common else self.move_base
                self.assertEqual(unknown_names(content, arrived), [], path)

    def test_layers(self):
        """The map first: what the camera sees now goes on top of it, what it inflates last."""
        for name, costmap in self.costmaps.items():
            self.assertEqual(layers_of(costmap), PLUGINS, name)

    def test_sources(self):
        for costmap in self.costmaps.values():
            self.assertEqual(set(costmap["obstacle_layer"]["observation_sources"].split()),
                             set(SOURCES))
        for where, name, source in self.sources():
            found = tuple(source[key] for key in ("data_type", "marking", "clearing"))
            self.assertEqual(found, SOURCES[name], where)
            self.assertTrue(source["topic"], where)
            self.assertEqual(source["expected_update_rate"], 0.0, where)
        for costmap in self.costmaps.values():
            self.assertTrue(costmap["obstacle_layer"]["scan"]["inf_is_valid"])

    def test_points_are_within_the_heights(self):
        contact_z = self.defaults()["output"]["contact_z"]
        for where, name, source in self.sources():
            z = 0.0 if name == "scan" else contact_z
            for tilted in (-0.1, 0.1):  # 3 degrees at 2 m
                self.assertLess(source["min_obstacle_height"], z + tilted, where)
                self.assertLess(z + tilted, source["max_obstacle_height"], where)
            self.assertLess(source["min_obstacle_height"], 0.0, where)  # the least contact_z

    def test_obstacle_range_ends_before_the_scan(self):
        defaults = self.defaults()
        range_max = (defaults["output"]["scan_range_max"] or defaults["sweep"]["max_range"]
                     or 2.0)  # or more, with a high camera
        for name, costmap in self.costmaps.items():
            self.assertLess(costmap["obstacle_layer"]["obstacle_range"], range_max - 0.01, name)
            self.assertGreaterEqual(costmap["obstacle_layer"]["raytrace_range"], range_max, name)

    def test_layers_are_combined_by_the_maximum(self):
        for name, costmap in self.costmaps.items():
            self.assertEqual(costmap["obstacle_layer"]["combination_method"], 1, name)

    def test_the_map_is_read_as_it_is_published(self):
        for name, costmap in self.costmaps.items():
            layer = costmap["static_layer"]
            self.assertTrue(layer["trinary_costmap"], name)
            self.assertEqual(layer["lethal_cost_threshold"], 100, name)
            self.assertEqual(layer["unknown_cost_value"], -1, name)
            self.assertFalse(layer["subscribe_to_updates"], name)

    def test_unknown_floor(self):
        """Planned through, but not a wall around the robot: DWA does not drive onto unknown."""
        for name, expected in (("global_costmap", True), ("local_costmap", False)):
            costmap = self.costmaps[name]
            for holder in (costmap, costmap["static_layer"]):
                self.assertEqual(holder["track_unknown_space"], expected, name)
        self.assertTrue(self.move_base["NavfnROS"]["allow_unknown"])

    def test_windows_follow_the_robot(self):
        for name, costmap in self.costmaps.items():
            self.assertTrue(costmap["rolling_window"], name)
            self.assertIsInstance(costmap["width"], int, name)
            self.assertIsInstance(costmap["height"], int, name)
            self.assertGreater(min(costmap["width"], costmap["height"]),
                               2 * costmap["obstacle_layer"]["obstacle_range"], name)
            self.assertEqual(costmap["obstacle_layer"]["transform_tolerance"],
                             costmap["transform_tolerance"], name)
        self.assertGreaterEqual(self.costmaps["global_costmap"]["width"], 30)

    def test_recovery_clears_layers_that_exist(self):
        self.assertFalse(self.move_base["clearing_rotation_allowed"])
        for name in ("conservative_reset", "aggressive_reset"):
            cleared = self.move_base[name]["layer_names"]
            self.assertEqual(cleared, ["obstacle_layer"], name)
            for costmap in self.costmaps.values():
                self.assertLessEqual(set(cleared), {each for each, _ in layers_of(costmap)})

    def test_turning_on_the_spot_is_reachable_from_rest(self):
        dwa = self.move_base["DWAPlannerROS"]
        step = 1.0 / self.move_base["controller_frequency"]
        self.assertLess(dwa["min_vel_theta"], dwa["acc_lim_theta"] * step)
        self.assertLess(dwa["min_vel_trans"], dwa["acc_lim_x"] * step)


class MoveBaseLaunch(unittest.TestCase):
    def check_topics(self, launch, *arguments):
        """Layers resolve topics in move_base's namespace, the chain in its nodelets'."""
        started = nodes(launch, *arguments)
        mapper, = (each for each in started if each.endswith("/mapper"))
        detector, = (each for each in started if each.endswith("/detector"))
        node, = (each for each in started if each.endswith("/move_base"))
        tree = below(node, parameters(launch, *arguments))
        for name in COSTMAPS:
            for topic, given in topics(tree[name]).items():
                publisher = mapper if topic == "map" else detector
                self.assertEqual(posixpath.join(posixpath.dirname(node), given),
                                 posixpath.join(posixpath.dirname(publisher), topic), name)

    def test_costmaps_listen_to_the_chain(self):
        self.check_topics(LAUNCH)

    def test_in_another_namespace(self):
        self.check_topics(LAUNCH, "namespace:=eye")
        self.check_topics(LAUNCH, "namespace:=/robot2/eye")

    def test_in_a_group(self):
        self.check_topics(IN_A_GROUP)

    def test_the_files_alone_name_the_same_topics(self):
        with open(os.path.join(PACKAGE, "config", "move_base", "costmap_common.yaml")) as file:
            content = yaml.safe_load(file)
        self.assertEqual(topics(content), topics(move_base()["global_costmap"]))

    def frames(self, *arguments):
        flat = parameters(LAUNCH, *arguments)
        costmaps = below("/move_base", flat)
        return (costmaps["local_costmap"]["global_frame"],
                costmaps["global_costmap"]["global_frame"],
                flat["/camera/mapper/global_frame"], flat["/camera/detector/odom_frame"])

    def test_frames(self):
        """The local costmap never jumps; the map is in the global costmap's frame."""
        self.assertEqual(self.frames(), ("odom", "odom", "", "odom"))
        self.assertEqual(self.frames("global_frame:=map"), ("odom", "map", "map", "odom"))
        self.assertEqual(self.frames("odom_frame:=wheels"), ("wheels", "wheels", "", "wheels"))
        tree = move_base("base_frame:=base_link")
        for name in COSTMAPS:
            self.assertEqual(tree[name]["robot_base_frame"], "base_link")

    def test_the_chain_gets_every_argument(self):
        given = ("base_frame:=b", "odom_frame:=o", "global_frame:=g", "correction:=keep",
                 "odometry_source:=tf", "profile:=paper", "detector:=chain", "pose_from_tf:=false",
                 "camera_x:=0.1", "camera_y:=0.2", "camera_z:=0.3", "camera_pitch:=0.4",
                 "calibration:=/c.yaml", "map_directory:=/m", "initial_map:=/i.yaml",
                 "image_transport:=compressed", "namespace:=eye")
        chain = os.path.join(PACKAGE, "launch", "chain.launch")
        self.assertEqual(below("/eye", parameters(LAUNCH, *given)),
                         below("/eye", parameters(chain, *given)))

    def test_the_chain_gets_every_topic(self):
        command = roslaunch("--args=/camera/detector", LAUNCH, "image:=/a", "camera_info:=/b",
                            "odom:=/c")
        for remapping in ("image_raw:=/a", "camera_info:=/b", "odom:=/c"):
            self.assertIn(remapping, command)

    def test_rviz(self):
        self.assertNotIn("/camera/rviz", nodes(LAUNCH))
        self.assertIn("/camera/rviz", nodes(LAUNCH, "rviz:=true"))
        self.assertIn("/camera/rviz", nodes(LAUNCH, "rviz:=true", "chain:=false"))

    def test_goals_from_rviz_do_not_stay_in_its_namespace(self):
        for path in glob.glob(os.path.join(PACKAGE, "rviz", "*.rviz")):
            with open(path) as file:
                tools = yaml.safe_load(file)["Visualization Manager"]["Tools"]
            goals = [each["Topic"] for each in tools if each["Class"] == "rviz/SetGoal"]
            self.assertEqual(goals, ["/move_base_simple/goal"], path)


if __name__ == "__main__":
    unittest.main()
