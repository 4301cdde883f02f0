#!/usr/bin/python3
"""Operating the nodelets: two instances side by side, compressed pictures, parameters that change
while they run, diagnostics that mean something, and maps that survive a restart."""

import os
import shutil
import subprocess
import unittest

import dynamic_reconfigure.client
import rospy
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
            for side in ('left', 'right', 'restarted')]
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

    def test_map_survives_a_restart(self):
        saved = rospy.ServiceProxy('/left/save_map', SaveMap)('kitchen')
        self.assertTrue(saved.success, saved.message)
        process = subprocess.Popen(
            ['rosrun', 'nodelet', 'nodelet', 'standalone', 'ipm_mapping/Mapper',
             '__name:=restarted', '_initial_map:=' + saved.message, 'map:=/restarted/map',
             'obstacles:=/nothing'])
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
