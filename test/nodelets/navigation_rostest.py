#!/usr/bin/python3
"""What costmap_2d does with scan, contacts, free and map, by its documented rules and with the
parameters of config/move_base: the box that the camera saw is an obstacle, the floor in front of it
is free, and nothing else is marked."""

import copy
import math
import os
import unittest

import rospy
import yaml
from ipm_mapping.msg import ObstacleArray
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan, PointCloud2
from sensor_msgs import point_cloud2

RESOLUTION = 0.05
LAST_FRAME = 19  # of the synthetic robot's twenty
BOX = (1.5, 1.8, -0.25, 0.15)  # x and y of the synthetic box


def distance_to_box(x, y):
    low_x, high_x, low_y, high_y = BOX
    return math.hypot(max(low_x - x, 0.0, x - high_x), max(low_y - y, 0.0, y - high_y))


def cell(x, y):
    return int(math.floor(x / RESOLUTION)), int(math.floor(y / RESOLUTION))


def centre(c):
    return (c[0] + 0.5) * RESOLUTION, (c[1] + 0.5) * RESOLUTION


class ObstacleLayer:
    """costmap_2d::ObstacleLayer with observation buffers, in the plane."""

    def __init__(self, parameters, sources):
        self.parameters = parameters
        self.sources = [(name, parameters[name]) for name in sources]
        self.cells = {}  # cell -> True (lethal) or False (free); absent: unknown

    def update(self, pose, points_of):
        """points_of: source name -> points (x, y, z) in the base frame."""
        seen = {name: self._buffered(source, points_of[name]) for name, source in self.sources}
        for name, source in self.sources:
            if source['clearing']:
                self._raytrace(pose, seen[name])
        for name, source in self.sources:
            if source['marking']:
                self._mark(pose, seen[name])

    @staticmethod
    def _buffered(source, points):
        low, high = source['min_obstacle_height'], source['max_obstacle_height']
        return [p for p in points if low <= p[2] <= high]

    @staticmethod
    def _to_odom(pose, x, y):
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        return pose.x + c * x - s * y, pose.y + s * x + c * y

    def _raytrace(self, pose, points):
        for x, y, _ in points:
            length = math.hypot(x, y)
            scale = min(1.0, self.parameters['raytrace_range'] / length)
            steps = max(1, int(length * scale / (0.4 * RESOLUTION)))
            for i in range(steps + 1):
                t = scale * i / steps
                self.cells[cell(*self._to_odom(pose, t * x, t * y))] = False

    def _mark(self, pose, points):
        for x, y, _ in points:
            if math.hypot(x, y) < self.parameters['obstacle_range']:
                self.cells[cell(*self._to_odom(pose, x, y))] = True

    def lethal(self):
        return [c for c, occupied in self.cells.items() if occupied]

    def free(self):
        return [c for c, occupied in self.cells.items() if not occupied]


def scan_points(scan, inf_is_valid):
    """costmap_2d's laserScanValidInfCallback, then laser_geometry's projection."""
    points = []
    for i, r in enumerate(scan.ranges):
        if inf_is_valid and math.isinf(r) and r > 0:
            r = scan.range_max - 0.0001
        if scan.range_min <= r < scan.range_max:
            a = scan.angle_min + i * scan.angle_increment
            points.append((r * math.cos(a), r * math.sin(a), 0.0))
    return points


def cut_scan(scan, range_max):
    """The same scan, published with a smaller range_max."""
    cut = copy.deepcopy(scan)
    cut.range_max = range_max
    cut.ranges = [float('inf') if r >= range_max else r for r in scan.ranges]
    return cut


def static_cells(grid, parameters):
    """costmap_2d::StaticLayer, trinary: cell -> True, False, or None where it writes `unknown`."""
    width, info, cells = grid.info.width, grid.info, {}
    for i, value in enumerate(grid.data):
        c = cell(info.origin.position.x + (i % width + 0.5) * info.resolution,
                 info.origin.position.y + (i // width + 0.5) * info.resolution)
        unknown = value == parameters['unknown_cost_value']
        cells[c] = (None if unknown and parameters['track_unknown_space'] else
                    value >= parameters['lethal_cost_threshold'])
    return cells


def combine(master, cells, maximum):
    """costmap_2d::CostmapLayer: unknown cells of the layer leave the master as it is."""
    for c, occupied in cells.items():
        if occupied is not None:
            master[c] = bool(maximum and master.get(c)) or occupied


class Navigation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.messages = {'obstacles': {}, 'scan': {}, 'contacts': {}, 'free': {}}
        cls.map = None
        kinds = {'obstacles': ObstacleArray, 'scan': LaserScan, 'contacts': PointCloud2,
                 'free': PointCloud2}
        cls.subscribers = [
            rospy.Subscriber('/camera/' + name, kind, cls.keep, name, queue_size=1000)
            for name, kind in kinds.items()]
        cls.subscribers.append(rospy.Subscriber('/camera/map', OccupancyGrid, cls.keep_map))
        while any(each.get_num_connections() == 0 for each in cls.subscribers):
            rospy.rostime.wallsleep(0.1)
        rospy.set_param('/listening', True)
        common = cls.load('costmap_common.yaml')
        cls.parameters = common['obstacle_layer']
        cls.local = cls.load('local_costmap.yaml')['local_costmap']
        cls.static_layer = dict(common['static_layer'], **cls.local['static_layer'])
        cls.wait_for_the_end()

    @staticmethod
    def load(name):
        with open(os.path.join(rospy.get_param('~config'), name)) as file:
            return yaml.safe_load(file)

    @classmethod
    def keep(cls, message, name):
        cls.messages[name][message.header.stamp] = message

    @classmethod
    def keep_map(cls, message):
        cls.map = message

    @classmethod
    def wait_for_the_end(cls):
        """The robot drives until the end, so that its last frame is answered; the map holds it."""
        for _ in range(1200):
            rospy.rostime.wallsleep(0.1)
            if cls.is_over():
                return

    @classmethod
    def is_over(cls):
        obstacles = cls.messages['obstacles']
        if not obstacles or max(each.frame for each in obstacles.values()) < LAST_FRAME:
            return False
        return (all(len(each) == len(obstacles) for each in cls.messages.values())
                and cls.map is not None and cls.map.header.stamp == max(obstacles))

    def points(self, name, stamp, range_max=None):
        message = self.messages[name][stamp]
        if name == 'scan':
            scan = cut_scan(message, range_max) if range_max else message
            return scan_points(scan, self.parameters['scan']['inf_is_valid'])
        return list(point_cloud2.read_points(message, ('x', 'y', 'z')))

    def layer(self, sources, range_max=None, parameters=None):
        layer = ObstacleLayer(parameters or self.parameters, sources)
        for stamp in sorted(self.messages['obstacles']):
            pose = self.messages['obstacles'][stamp].view.pose
            layer.update(pose, {name: self.points(name, stamp, range_max) for name in sources})
        return layer

    def marking_scan(self, obstacle_range):
        """Parameters of somebody who marks from the scan alone."""
        return dict(self.parameters, obstacle_range=obstacle_range,
                    scan=dict(self.parameters['scan'], marking=True))

    def check(self, layer):
        on_box = [c for c in layer.lethal() if distance_to_box(*centre(c)) < 0.1]
        elsewhere = [centre(c) for c in layer.lethal() if distance_to_box(*centre(c)) > 0.15]
        self.assertGreater(len(on_box), 3, 'the box is not marked')
        self.assertEqual(elsewhere, [], 'something that is not there is marked')
        ahead = [c for c in layer.free()
                 if 0.6 < centre(c)[0] < 1.35 and abs(centre(c)[1]) < 0.15]
        self.assertGreater(len(ahead), 0.9 * (0.75 * 0.3) / RESOLUTION ** 2,
                           'the floor in front of the box is not free')

    def test_every_frame_has_its_scan_and_its_clouds(self):
        self.assertGreater(len(self.messages['obstacles']), 10)
        for name in ('scan', 'contacts', 'free'):
            self.assertEqual(set(self.messages[name]), set(self.messages['obstacles']))

    def test_scan_alone_can_mark_the_box_and_clear_the_floor(self):
        self.check(self.layer(['scan'], parameters=self.marking_scan(1.95)))

    def test_scan_must_not_mark_at_its_end(self):
        """The rule obstacle_range < range_max, and that this test sees what breaks it."""
        self.check(self.layer(['scan'], 1.85, self.marking_scan(1.8)))
        ring = self.layer(['scan'], 1.0, self.marking_scan(1.95)).lethal()
        self.assertGreater(len([c for c in ring if distance_to_box(*centre(c)) > 0.15]), 3)

    def test_contacts_and_free_alone_do_too(self):
        self.check(self.layer(['contacts', 'free']))

    def test_all_sources_together_do(self):
        self.check(self.layer(self.parameters['observation_sources'].split()))

    def test_a_scan_that_ends_earlier_makes_no_ring(self):
        """sweep/max_range or output/scan_range_max may be lower than obstacle_range."""
        for range_max in (1.0, 1.5, 1.85):
            self.check(self.layer(self.parameters['observation_sources'].split(), range_max))

    def test_the_configuration_reads_what_is_published(self):
        self.assertEqual(self.parameters['observation_sources'].split(),
                         ['scan', 'contacts', 'free'])
        for scan in self.messages['scan'].values():
            # +Inf becomes a point at range_max: it must clear and must not mark.
            self.assertLess(self.parameters['obstacle_range'], scan.range_max - 0.0001)
            self.assertGreaterEqual(self.parameters['raytrace_range'], scan.range_max)
        self.assertTrue(self.parameters['scan']['inf_is_valid'])
        self.assertFalse(self.parameters['scan']['marking'], 'free rays may end in an obstacle')
        self.assertTrue(self.parameters['contacts']['marking'])
        self.assertFalse(self.parameters['free']['marking'], 'free floor would be an obstacle')
        self.assertFalse(self.parameters['contacts']['clearing'])

    def test_clouds_pass_the_default_height_window(self):
        for name in ('contacts', 'free'):
            for stamp in self.messages[name]:
                for _, _, z in self.points(name, stamp):
                    self.assertTrue(0.0 < z < 2.0)

    def test_rays_start_in_a_frame_of_the_robot(self):
        for name in ('scan', 'contacts', 'free'):
            for message in self.messages[name].values():
                self.assertEqual(message.header.frame_id, 'base_footprint')

    def test_static_layer_reads_the_map_as_it_is(self):
        """costmap_2d::StaticLayer, trinary, lethal_cost_threshold 100."""
        self.assertEqual(self.map.header.frame_id, 'odom')
        cells = static_cells(self.map, dict(self.static_layer, track_unknown_space=True))
        lethal = [c for c, occupied in cells.items() if occupied]
        self.assertGreater(list(cells.values()).count(False), 300)
        self.assertGreater(len(lethal), 3)
        for c in lethal:
            self.assertLess(distance_to_box(*centre(c)), 0.15)

    def local_costmap(self, obstacle_layer):
        """The plugins of local_costmap.yaml, one on top of the other."""
        master = {}
        for plugin in self.local['plugins']:
            if plugin['name'] == 'static_layer':
                master.update(static_cells(self.map, self.static_layer))
            elif plugin['name'] == 'obstacle_layer':
                combine(master, obstacle_layer.cells, self.parameters['combination_method'] == 1)
        return master

    def test_what_passes_below_the_view_stays_in_the_local_costmap(self):
        layer = self.layer(self.parameters['observation_sources'].split())
        pose = self.messages['obstacles'][max(self.messages['obstacles'])].view.pose
        over_the_box = [(2.5 * math.cos(a), 2.5 * math.sin(a), 0.0)
                        for a in (0.002 * i for i in range(-600, 601))]
        layer.update(pose, {'scan': over_the_box, 'contacts': [], 'free': []})
        self.assertEqual(layer.lethal(), [], 'the rays were meant to clear the box')
        costmap = self.local_costmap(layer)
        on_box = [c for c in costmap if costmap[c] and distance_to_box(*centre(c)) < 0.1]
        self.assertGreater(len(on_box), 3, 'the box has vanished')

    def test_the_local_costmap_has_no_unknown_cells(self):
        """DWA does not drive onto them."""
        self.assertIn(-1, self.map.data)
        layer = self.layer(self.parameters['observation_sources'].split())
        self.assertNotIn(None, self.local_costmap(layer).values())
        self.assertFalse(self.local['track_unknown_space'])


if __name__ == '__main__':
    import rostest
    rospy.init_node('navigation_rostest')
    rostest.rosrun('ipm_mapping', 'navigation_rostest', Navigation)
