"""The advice of docs/tuning.md as runs of offline_mapper: a scene, and values to compare."""
import os

from . import tables
from .experiments import ROOT, Case

FRAMES = 80  # of each scene
FALSE, ERROR = ("false_percent", "false %"), ("median_error_cm", "median cm")
RECALL, FRAMES_USED = ("recall_percent", "recall %"), ("frames_used", "frames used")
MAP_FALSE = ("map_false_cells_percent", "map false %")
MAP_COVERAGE = ("map_coverage_percent", "map coverage %")
EMPTY = ("contact_bearings_percent", "bearings with a contact, %")
TIME = ("time", "time")


class Advice:
    """One table: `values` are lists of settings of offline_mapper, the empty one first."""

    def __init__(self, name, scene, columns, values, detector="default", hidden=()):
        self.name, self.case, self.columns = name, Case(scene, frames=FRAMES), columns
        self.values, self.detector, self.hidden = values, detector, tuple(hidden)

    def table(self, bench):
        rows, unit = [], None
        for settings in self.values:
            used = tuple(settings) + (self.hidden if settings else ())
            figures = bench.figures(self.case, self.detector, used)
            unit = unit or milliseconds(figures)
            figures["time"] = milliseconds(figures) / unit
            rows.append([", ".join(f"`{s}`" for s in settings) or "as it is"]
                        + [tables.cell(figures.get(key)) for key, _ in self.columns])
        return tables.table([f"`{self.case.scene}`"] + [title for _, title in self.columns], rows)


def milliseconds(figures):
    """Of a frame: the stages' medians, which a busy machine disturbs least."""
    return sum(each["median_ms"] for each in figures["report"]["stages"].values())


def with_tables(text, made):
    """`text` with each table between its marks replaced; raises ValueError where there are none."""
    for name, table in made.items():
        begin, end = f"<!-- table {name} -->\n", f"<!-- end of {name} -->"
        before, found, rest = text.partition(begin)
        old, closed, after = rest.partition(end)
        if not found or not closed:
            raise ValueError(f"there is no place for the table {name}")
        text = before + begin + table + "\n" + end + after
    return text


def write_tables(page, made):
    """Tables into a page of docs/, between their marks."""
    path = os.path.join(ROOT, "docs", page)
    with open(path) as file:
        text = file.read()
    with open(path, "w") as file:
        file.write(with_tables(text, made))
    print("written:", path)


ADVICE = [
    Advice("pitch", "pitch_off", [ERROR, FALSE, RECALL, MAP_COVERAGE],
           [[], ["camera/pitch=0.4287"], ["camera/pitch=0.4374"]],
           hidden=["camera/pose_from_tf=false", "camera/x=0.05", "camera/y=-0.01", "camera/z=0.45"]),
    Advice("late", "lab_normal", [ERROR, FALSE, RECALL],
           [[], ["camera/image_time_offset=-0.05"], ["camera/image_time_offset=-0.1"],
            ["camera/image_time_offset=-0.1", "calibration/learn_time_offset=false"]]),
    Advice("slip", "wheel_slip", [FALSE, ERROR, RECALL, MAP_FALSE, MAP_COVERAGE],
           [[], ["sweep/sd_forward=0.1"], ["floor_odometry/poses=refined"]]),
    Advice("turn", "yaw_bias", [FALSE, ERROR, RECALL, MAP_FALSE, MAP_COVERAGE],
           [[], ["sweep/sd_turn=0.03"], ["floor_odometry/poses=refined"]]),
    Advice("misses", "lab_hard", [RECALL, FALSE, ERROR],
           [[], ["sweep/specular_prior=9"]]),
    Advice("shine", "lab_hard", [FALSE, RECALL, ERROR],
           [[], ["sweep/publish_score=10"], ["sweep/publish_slope=40"]]),
    Advice("map", "lab_hard", [MAP_FALSE, MAP_COVERAGE],
           [[], ["map/hit=0.4"], ["map/hit=2"]]),
    Advice("baseline", "lab_normal", [FRAMES_USED, ERROR, FALSE, RECALL],
           [[], ["sweep/short_baseline=0.1"]]),
    Advice("slow", "lab_normal", [TIME, ERROR, FALSE, RECALL],
           [[], ["sweep/rows_per_log=100"], ["sweep/lines_per_radian=200"],
            ["sweep/long_baseline=0"]]),
    Advice("chain", "empty_tiles", [EMPTY],
           [[], ["segmentation/min_threshold=0"], ["segmentation/min_threshold=16"]],
           detector="chain"),
]
