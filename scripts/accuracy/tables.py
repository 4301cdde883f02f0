"""The report's tables as Markdown."""

COLUMNS = [
    ("false_percent", "false %"), ("median_error_cm", "median cm"), ("p90_error_cm", "p90 cm"),
    ("recall_percent", "recall %"), ("map_false_cells_percent", "map false %"),
    ("map_coverage_percent", "map coverage %"), ("points", "points"), ("frames_used", "frames"),
]

# Table 7.2 of the source: false points of its experiment 2, judged by eye.
SOURCE_FALSE_PERCENT = {"normal conditions": (8, 2, 6), "hard conditions": (16, 7, 9)}


def cell(value):
    if value is None:
        return "–"
    return str(value) if isinstance(value, int) else f"{value:.2f}"


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)


def is_empty(figures):
    """Nothing stands in the scene: only the empty-floor rate says something."""
    return figures["visible_bearings"] == 0


def scenes_table(results, detector):
    rows = []
    for scene, by_detector in results.items():
        figures = by_detector[detector]
        if not is_empty(figures):
            rows.append([scene] + [cell(figures.get(key)) for key, _ in COLUMNS])
    return table(["scene"] + [title for _, title in COLUMNS], rows)


def empty_table(results, detectors):
    rows = [[scene] + [cell(by_detector[d]["contact_bearings_percent"]) for d in detectors]
            for scene, by_detector in results.items() if is_empty(by_detector[detectors[0]])]
    return table(["floor with nothing on it: bearings with a contact, %"] + detectors, rows)


def kinds_table(results, detector):
    """Over all scenes: recall and error of each kind of obstacle."""
    sums = {}
    for by_detector in results.values():
        for kind, row in by_detector[detector]["kinds"].items():
            entry = sums.setdefault(kind, [0, 0.0, []])
            entry[0] += row["visible_bearings"]
            entry[1] += row["recall_percent"] * row["visible_bearings"] / 100
            if row["median_error_cm"] is not None:
                entry[2].append((row["median_error_cm"], row["visible_bearings"]))
    rows = []
    for kind, (asked, found, errors) in sorted(sums.items()):
        weight = sum(n for _, n in errors)
        error = sum(e * n for e, n in errors) / weight if weight else None
        rows.append([kind, cell(asked), cell(100 * found / asked), cell(error)])
    return table(["kind", "visible bearings", "recall %", "mean of the scenes' medians, cm"], rows)


def source_table(results, detectors):
    """False points beside the source's table 7.2."""
    pairs = [("normal conditions", "lab_normal"), ("hard conditions", "lab_hard")]
    rows = []
    for condition, scene in pairs:
        if scene not in results:
            continue
        total, shine, shadow = SOURCE_FALSE_PERCENT[condition]
        rows.append([f"{condition} ({scene})", f"{total} ({shine} shine + {shadow} shadow)"]
                    + [cell(results[scene][d]["false_percent"]) for d in detectors])
    return table(["false points, %", "source, table 7.2, by eye"] + detectors, rows)


def speed_row(figures):
    report = figures["report"]
    return report.get("total_fps")


def document(results, sensitivities, detectors, command, pictures):
    """The whole report; pictures maps a title to a path relative to the document."""
    parts = ["# Accuracy", "", "Made by", "", "```", command, "```", "",
             "Every contact within 2 m is placed with the true pose. *False*: farther than 10 cm "
             "from every outline. *Recall*: of the bearings whose first obstacle is visible "
             "between 0.4 and 2 m, the share with a contact within 10 cm. *Map*: occupied 5 cm "
             "cells with the odometry as recorded; coverage is of the outline cells that were "
             "ever visible within 2 m. No filter over time, except in the map.", "",
             "## Beside the source", "", source_table(results, detectors), ""]
    for detector in detectors:
        parts += [f"## {detector}", "", scenes_table(results, detector), ""]
        parts += [kinds_table(results, detector), ""]
    parts += ["## Empty floors", "", empty_table(results, detectors), ""]
    if sensitivities:
        parts += ["## Sensitivity", ""]
        for sweep in sensitivities:
            parts += [sweep.table(), ""]
    for title, path in pictures.items():
        parts += [f"![{title}]({path})", ""]
    return "\n".join(parts)
