"""What becomes of scenes out of a hat, as tables: one row a scene, and all of them together."""
import numpy as np

from . import random_scenes, tables

COLUMNS = [("false_percent", "false %"), ("median_error_cm", "median cm"),
           ("recall_percent", "recall %"), ("free_beyond_percent", "free beyond %")]
LOW_IS_BAD = ("recall_percent",)


def scene_row(number, by_detector):
    made = random_scenes.scene(number)
    return [str(number), random_scenes.room(number), made["floor"]["grain"],
            f"{made['camera']['z']:.2f}", f"{made['camera']['fx']:.0f}",
            *(" / ".join(tables.cell(f[key]) for f in by_detector.values()) for key, _ in COLUMNS)]


def scenes_table(results, detectors):
    """`results` are figures by detector of each number."""
    header = [" / ".join(detectors), "room", "floor", "height m", "focal px"]
    return tables.table(header + [title for _, title in COLUMNS],
                        [scene_row(number, figures) for number, figures in results.items()])


def worst_tenth(key, values):
    return np.percentile(values, 10 if key in LOW_IS_BAD else 90)


STATISTICS = {"mean": lambda key, values: np.mean(values),
              "median": lambda key, values: np.median(values), "worst tenth": worst_tenth}


def false_goal(number):
    polished = random_scenes.is_polished(random_scenes.scene(number))
    return tables.FALSE_GOAL_GLOSSY if polished else tables.FALSE_GOAL


# Whether a scene's figure is good enough; there is no goal for free floor.
GOALS = {"false_percent": lambda number, value: value <= false_goal(number),
         "median_error_cm": lambda number, value: value <= tables.MEDIAN_GOAL,
         "recall_percent": lambda number, value: value >= tables.RECALL_GOAL}


def statistic_row(results, detector, name):
    row = [detector, name]
    for key, _ in COLUMNS:
        values = [f[detector][key] for f in results.values() if f[detector][key] is not None]
        row.append(tables.cell(float(STATISTICS[name](key, values)) if values else None))
    return row


def goals_row(results, detector):
    row = [detector, "reach the goal"]
    for key, _ in COLUMNS:
        figures = {number: f[detector][key] for number, f in results.items()}
        good = [value is not None and GOALS[key](number, value)
                for number, value in figures.items() if key in GOALS]
        row.append(f"{sum(good)} of {len(good)}" if good else "–")
    return row


def summary_table(results, detectors):
    rows = []
    for detector in detectors:
        rows += [statistic_row(results, detector, name) for name in STATISTICS]
        rows.append(goals_row(results, detector))
    false, median, recall, free = (title for _, title in COLUMNS)
    return tables.table(
        ["detector", f"{len(results)} scenes",
         f"{false} (≤ {tables.FALSE_GOAL}; mirror floor ≤ {tables.FALSE_GOAL_GLOSSY})",
         f"{median} (≤ {tables.MEDIAN_GOAL})", f"{recall} (≥ {tables.RECALL_GOAL:g})", free], rows)
