"""Curves: one quantity of a scene or of a detector is changed, everything else stays."""
from .experiments import Case
from .tables import cell, table

SHOWN = [("false_percent", "false %"), ("median_error_cm", "median cm"),
         ("recall_percent", "recall %")]
DEGREE = 0.017453292519943295


class Sweep:
    """Values of one quantity and the figures at each, for each detector."""

    def __init__(self, title, unit, values, scene_changes=None, settings=None, scene="lab_normal"):
        self.title, self.unit, self.values, self.scene = title, unit, values, scene
        self.scene_changes = scene_changes or (lambda value: [])
        self.settings = settings or (lambda value, detector: [])
        self.figures = {}

    def run(self, bench, detectors):
        for value in self.values:
            label = f"{self.scene}-{self.title}-{value:g}".replace(" ", "_")
            changes = self.scene_changes(value)
            case = Case(self.scene, label, changes) if changes else Case(self.scene)
            for detector in detectors:
                figures = bench.figures(case, detector, self.settings(value, detector))
                self.figures.setdefault(detector, []).append(figures)

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


def _speed(value):
    """The same path at another speed: commands scaled, segments stretched."""
    drive = [(4, 0.25, 0.0), (3, 0.25, 0.05), (6, 0.24, -0.06), (4, 0.22, 0.1)]
    ratio = value / 0.25
    rows = [f"{{seconds: {s / ratio:.4f}, v: {v * ratio:.4f}, w: {w * ratio:.4f}}}"
            for s, v, w in drive]
    return ["drive=[" + ", ".join(rows) + "]"]


def _baseline(value, detector):
    """Metres between the two frames that are compared, in each detector's own words."""
    if detector == "default":
        heights = value / 0.45
        return [f"sweep/short_baseline={0.5 * heights:.4f}",
                f"sweep/long_baseline={heights:.4f}"]
    return [f"reference/min_baseline={value:g}", "reference/previous_frame=false"]


def sweeps():
    return [
        Sweep("pitch error", "degrees", [-2, -1, -0.5, -0.2, -0.1, 0, 0.1, 0.2, 0.5, 1, 2],
              lambda v: [f"camera.pitch_error={v * DEGREE:.6f}"]),
        Sweep("yaw rate bias", "degrees/s", [-2, -1, -0.5, 0, 0.5, 1, 2],
              lambda v: [f"odometry.yaw_bias={v * DEGREE:.6f}"]),
        Sweep("distance scale error", "percent", [-5, -2, -1, 0, 1, 2, 5],
              lambda v: [f"odometry.scale={v / 100}"]),
        Sweep("speed", "m/s", [0.1, 0.25, 0.5, 0.8], _speed),
        Sweep("sensor noise", "grey levels in the mid-tones", [0.7, 1.3, 2.5, 4, 6],
              lambda v: [f"sensor.full_well={9000 * (1.3 / v) ** 2:.0f}"]),
        Sweep("baseline", "m", [0.05, 0.1, 0.2, 0.3, 0.45], settings=_baseline),
    ]
