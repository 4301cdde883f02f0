"""Curves: one quantity of a scene or of a detector is changed, everything else stays."""
import math
import os

import yaml

from .experiments import SCENES, Case
from .tables import cell, table

SHOWN = [("false_percent", "false %"), ("median_error_cm", "median cm"),
         ("recall_percent", "recall %")]
SCENE = "lab_normal"
FRAMES = 60
WEAVING, WEAVING_FRAMES = "late_stamps", 120
NOISE, FULL_WELL = 1.3, 9000  # grey levels in the mid-tones; electrons
DEGREE = math.pi / 180


class Sweep:
    """Values of one quantity and the figures at each, for each detector."""

    def __init__(self, title, unit, values, case=None, settings=None):
        self.title, self.unit, self.values = title, unit, values
        self.case = case or (lambda value: Case(SCENE, frames=FRAMES))
        self.settings = settings or (lambda value, detector: [])
        self.figures = {}

    def work(self, detectors):
        """What the bench has to do: (detector, (case, detector, settings)) of each value."""
        return [(d, (self.case(value), d, self.settings(value, d)))
                for value in self.values for d in detectors]

    def run(self, bench, detectors):
        for detector, one in self.work(detectors):
            self.figures.setdefault(detector, []).append(bench.figures(*one))

    def table(self):
        header = [f"{self.title}, {self.unit}"]
        header += [f"{detector}: {title}" for detector in self.figures for _, title in SHOWN]
        rows = []
        for i, value in enumerate(self.values):
            row = [f"{value:g}"]
            for series in self.figures.values():
                row += [cell(series[i][key]) for key, _ in SHOWN]
            rows.append(row)
        return table(header, rows)


def _scene():
    with open(os.path.join(SCENES, SCENE + ".yaml")) as file:
        return yaml.safe_load(file)


def _odometry(key, scale):
    """The scene with another error of its odometry."""
    return lambda value: Case(SCENE, [f"odometry.{key}={value * scale:.8g}"], FRAMES)


def _noisy(value):
    """Shot noise in the mid-tones is inversely proportional to the root of the full well."""
    full_well = round(FULL_WELL * (NOISE / value) ** 2)
    return Case(SCENE, [f"sensor.full_well={full_well}"] if value != NOISE else [], FRAMES)


def _speed(value):
    """The same path at another speed: commands scaled, segments stretched, frames to its end."""
    drive = _scene()["drive"]
    ratio = value / drive[0]["v"]
    if ratio == 1:
        return Case(SCENE, frames=FRAMES)
    rows = [f"{{seconds: {s['seconds'] / ratio:.4f}, v: {s['v'] * ratio:.4f}, "
            f"w: {s['w'] * ratio:.4f}}}" for s in drive]
    return Case(SCENE, ["drive=[" + ", ".join(rows) + "]"], round(FRAMES / ratio))


def _weaving(key):
    """A robot that weaves, its stamps right unless they are what is changed; in milliseconds."""
    def case(value):
        changes = {"stamp_error": 0.0, key: 1e-3 * value}
        return Case(WEAVING, [f"sensor.{k}={v:g}" for k, v in changes.items()], WEAVING_FRAMES)
    return case


def _baseline(value, detector):
    """Metres between the two frames that are compared, in each detector's own words."""
    if detector == "default":
        heights = value / _scene()["camera"]["z"]
        return [f"sweep/short_baseline={0.5 * heights:.4f}", f"sweep/long_baseline={heights:.4f}"]
    return [f"reference/min_baseline={value:g}", "reference/previous_frame=false"]


def _mounting(key, scale):
    """The mapper is told a wrong mounting; the value is what is true minus what is stated."""
    def settings(value, _):
        camera = {name: _scene()["camera"][name] for name in ("x", "y", "z", "pitch")}
        camera[key] -= value * scale
        return ["camera/pose_from_tf=false"] + [f"camera/{k}={v:.6g}" for k, v in camera.items()]
    return settings


def sweeps():
    return [
        Sweep("pitch error", "degrees", [-2, -1, -0.5, -0.2, 0, 0.2, 0.5, 1, 2],
              settings=_mounting("pitch", DEGREE)),
        Sweep("height error", "cm", [-2, -1, 0, 1, 2], settings=_mounting("z", 0.01)),
        Sweep("baseline", "m", [0.05, 0.1, 0.2, 0.3, 0.45], settings=_baseline),
        Sweep("yaw rate bias", "degrees per s", [-1, -0.5, -0.25, 0, 0.25, 0.5, 1, 2],
              _odometry("yaw_bias", DEGREE)),
        Sweep("distance scale error", "percent", [-2, 2, 5], _odometry("scale", 0.01)),
        Sweep("speed", "m per s", [0.125, 0.25, 0.5, 1.0], _speed),
        Sweep("sensor noise", "grey levels in the mid-tones",
              [0.5 * NOISE, NOISE, 2 * NOISE, 4 * NOISE], _noisy),
        Sweep("stamp error", "ms too late, while weaving", [-100, -50, 0, 50, 100, 150],
              _weaving("stamp_error")),
        Sweep("readout time", "ms, while weaving", [0, 10, 20, 30, 40], _weaving("readout_time")),
    ]
