#!/usr/bin/python3
"""Operating the nodelets: two instances side by side, compressed pictures, parameters that change
while they run, diagnostics that mean something, and maps that survive a restart."""

import os
import shutil
import subprocess
import unittest

import dynamic_reconfigure.client
import numpy
import PIL.Image
import rospy
import yaml
from diagnostic_msgs.msg import DiagnosticArray
from ipm_mapping.msg import ObstacleArray
from ipm_mapping.srv import SaveMap
from nav_msgs.msg import OccupancyGrid
from std_srvs.srv import Trigger


def wait_for(done, seconds=30.0):
    for _ in range(int(seconds / 0.05)):
        if done():
            return True
        rospy.rostime.wallsleep(0.05)
    return False


def read_map(path):
    """A saved map as the map server would publish it."""
    with open(path, encoding='ascii') as file:
        described = yaml.safe_load(file)
    try:
        picture = numpy.asarray(
            PIL.Image.open(os.path.join(os.path.dirname(path), described['image'])))
    except FileNotFoundError:  # a save has ended meanwhile
        return read_map(path)
    grid = OccupancyGrid()
    grid.info.height, grid.info.width = picture.shape
    grid.info.origin.position.x, grid.info.origin.position.y = described['origin'][:2]
    grid.data = numpy.select([picture == 0, picture == 254], [100, 0], -1)[::-1].ravel().tolist()
    return grid


def same_map(a, b):
    places = [(m.info.width, round(m.info.origin.position.x, 6), round(m.info.origin.position.y, 6))
              for m in (a, b)]
    return places[0] == places[1] and list(a.data) == list(b.data)


class Operation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.directory = rospy.get_param('~directory')
        cls.obstacles = {'left': [], 'right': []}
        cls.maps, cls.said = {}, {}
        cls.subscribers = [
            rospy.Subscriber('/%s/obstacles' % side, ObstacleArray, cls.obstacles[side].append)
            for side in cls.obstacles]
        cls.subscribers += [
            rospy.Subscriber('/%s/map' % side, OccupancyGrid, cls.keep_map, side)
            for side in ('left', 'right', 'restarted', 'reloaded', 'emptied', 'reopened')]
        cls.diagnostics = rospy.Subscriber('/diagnostics', DiagnosticArray, cls.keep_status)
        assert wait_for(lambda: all(s.get_num_connections() > 0 for s in cls.subscribers[:4]))
        assert wait_for(lambda: len(cls.said) >= 5)
        rospy.set_param('/listening', True)
        wait_for(lambda: all(a and a[-1].frame == 19 for a in cls.obstacles.values()))
        wait_for(lambda: all(cls.maps[side].header.stamp == cls.obstacles[side][-1].header.stamp
                             for side in cls.obstacles))

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.directory, ignore_errors=True)

    @classmethod
    def keep_map(cls, message, side):
        cls.maps[side] = message

    @classmethod
    def keep_status(cls, message):
        for status in message.status:
            history = cls.said.setdefault(status.name.split(':')[0], [])
            history.append((status.level, status.message,
                            {pair.key: float(pair.value) for pair in status.values
                             if not pair.key.startswith('fault_')}))

    def test_both_instances_answer_compressed_pictures(self):
        for side, detector in (('left', 'sweep'), ('right', 'chain')):
            self.assertGreater(len(self.obstacles[side]), 8)
            self.assertEqual({each.detector for each in self.obstacles[side]}, {detector})

    def test_diagnostics_say_what_is_going_on(self):
        for nodelet in ('left/detector', 'left/mapper', 'right/ipm', 'right/segmentation',
                        'right/localization', 'right/mapper'):
            at_work = [s for s in self.said[nodelet] if s[2]['used_rate_hz'] > 0]
            self.assertTrue(at_work, nodelet)
            self.assertTrue(all(level == 0 for level, _, _ in at_work), nodelet)
            self.assertTrue(all(values['input_rate_hz'] > 0 for _, _, values in at_work))
            self.assertIn('latency_s', at_work[0][2])
            # The bag is over: a stage that waits for input says for which.
            self.assertTrue(wait_for(lambda: self.said[nodelet][-1][0] == 1), nodelet)
            self.assertIn('nothing comes in on /', self.said[nodelet][-1][1])
        self.assertIn('odometry_behind_images_s', self.said['right/ipm'][-1][2])
        self.assertIn('separability', self.said['right/segmentation'][-1][2])
        self.assertGreater(self.said['left/mapper'][-1][2]['map_width_m'], 3.0)
        self.assertEqual(self.said['left/detector'][-1][2]['received'], 20)

    def test_parameters_change_through_dynamic_reconfigure(self):
        client = dynamic_reconfigure.client.Client('/right/segmentation', timeout=10)
        described = {p['name']: p for p in client.get_parameter_descriptions()}
        self.assertEqual(described['segmentation/min_threshold']['max'], 255)
        self.assertEqual(described['segmentation/min_threshold']['default'], 6)
        answer = client.update_configuration({'segmentation/min_threshold': 42})
        self.assertEqual(answer['segmentation/min_threshold'], 42)
        answer = client.update_configuration({'segmentation/min_threshold': 9999})
        self.assertEqual(answer['segmentation/min_threshold'], 255, 'clamped to the range')
        client.close()

    def test_autosave_leaves_a_map(self):
        self.assertTrue(wait_for(
            lambda: os.path.exists(os.path.join(self.directory, 'autosave.yaml'))))

    def start_mapper(self, name, *arguments):
        return subprocess.Popen(
            ['rosrun', 'nodelet', 'nodelet', 'standalone', 'ipm_mapping/Mapper', '__name:=' + name,
             'map:=/%s/map' % name, 'obstacles:=/%s/obstacles' % name, *arguments])

    def test_a_killed_mapper_finds_again_what_it_had_saved_by_itself(self):
        maps = []
        listener = rospy.Subscriber('/killed/map', OccupancyGrid, maps.append)
        feeder = rospy.Publisher('/killed/obstacles', ObstacleArray, queue_size=100)
        answers = self.obstacles['left']
        saved = os.path.join(self.directory, 'killed.yaml')

        def feed(begin, end):
            for answer in answers[begin:end]:
                feeder.publish(answer)
                self.assertTrue(
                    wait_for(lambda a=answer: maps and maps[-1].header.stamp == a.header.stamp))

        process = self.start_mapper(
            'killed', '_directory:=' + self.directory, '_autosave_name:=killed',
            '_autosave_period:=0.3', '_publish_rate:=0', '_full_map_period:=0')
        try:
            self.assertTrue(wait_for(lambda: feeder.get_num_connections() > 0
                                     and listener.get_num_connections() > 0))
            feed(0, 4)
            self.assertTrue(wait_for(lambda: os.path.exists(saved)))
            feed(4, 7)
            certain = len(maps) - 1
            self.assertTrue(wait_for(lambda: same_map(read_map(saved), maps[certain])))
            feed(7, len(answers))
        finally:
            process.kill()
            process.wait()
        reloaded = self.start_mapper('reloaded', '_initial_map:=' + saved)
        try:
            self.assertTrue(wait_for(lambda: 'reloaded' in self.maps))
        finally:
            reloaded.terminate()
            reloaded.wait()
        self.assertTrue(any(same_map(self.maps['reloaded'], each) for each in maps[certain:]))

    def test_a_killed_mapper_does_not_find_again_what_was_thrown_away(self):
        feeder = rospy.Publisher('/emptied/obstacles', ObstacleArray, queue_size=100)
        saved = os.path.join(self.directory, 'emptied.yaml')
        last = self.obstacles['left'][-1].header.stamp

        def kept():
            return os.path.exists(saved) and set(read_map(saved).data) != {-1}

        process = self.start_mapper(
            'emptied', 'reset_map:=/emptied/reset_map', '_directory:=' + self.directory,
            '_autosave_name:=emptied', '_autosave_period:=0.3', '_publish_rate:=0',
            '_full_map_period:=0')
        try:
            self.assertTrue(wait_for(lambda: feeder.get_num_connections() > 0
                                     and 'emptied' in self.maps))
            for answer in self.obstacles['left']:
                feeder.publish(answer)
            self.assertTrue(wait_for(lambda: self.maps['emptied'].header.stamp == last))
            self.assertTrue(wait_for(kept))
            self.assertTrue(rospy.ServiceProxy('/emptied/reset_map', Trigger)().success)
            self.assertTrue(wait_for(lambda: not kept(), 5.0), 'the old map is still in the file')
        finally:
            process.kill()
            process.wait()
        reopened = self.start_mapper('reopened', '_initial_map:=' + saved)
        try:
            self.assertTrue(wait_for(lambda: 'reopened' in self.maps))
            self.assertEqual(set(self.maps['reopened'].data), {-1})
        finally:
            reopened.terminate()
            reopened.wait()

    def test_map_survives_a_restart(self):
        saved = rospy.ServiceProxy('/left/save_map', SaveMap)('kitchen')
        self.assertTrue(saved.success, saved.message)
        process = self.start_mapper('restarted', '_initial_map:=' + saved.message)
        try:
            self.assertTrue(wait_for(lambda: 'restarted' in self.maps))
            self.assertEqual(self.maps['restarted'].data, self.maps['left'].data)
            self.assertEqual(self.maps['restarted'].info.origin, self.maps['left'].info.origin)
        finally:
            process.terminate()
            process.wait()

    def test_zz_reset_of_one_instance_leaves_the_other(self):
        before = self.maps['right'].data
        self.assertTrue(rospy.ServiceProxy('/left/reset_map', Trigger)().success)
        self.assertTrue(wait_for(lambda: set(self.maps['left'].data) == {-1}))
        self.assertEqual(self.maps['right'].data, before)


if __name__ == '__main__':
    import rostest
    rospy.init_node('operation_rostest')
    rostest.rosrun('ipm_mapping', 'operation_rostest', Operation)
