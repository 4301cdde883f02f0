"""The report's tables as Markdown."""
import os

from .experiments import HELD_OUT

FINDINGS, FINDINGS_END = "<!-- findings: kept as written -->", "<!-- end of the findings -->"

COLUMNS = [
    ("false_percent", "false %"), ("median_error_cm", "median cm"), ("p90_error_cm", "p90 cm"),
    ("recall_percent", "recall %"), ("map_false_cells_percent", "map false %"),
    ("map_coverage_percent", "map coverage %"), ("free_beyond_percent", "free beyond %"),
    ("free_way_percent", "free way %"), ("points", "points"), ("frames_used", "frames"),
]

# Table 7.2 of the source: false points of its experiment 2, judged by eye.
SOURCE_FALSE_PERCENT = {"normal conditions": (8, 2, 6), "hard conditions": (16, 7, 9)}

# What the default profile is meant to reach; false points have two goals.
GLOSSY = {"lab_hard", "empty_shine", "held_out_gloss", "held_out_empty"}
FALSE_GOAL, FALSE_GOAL_GLOSSY = 0.3, 0.5
MEDIAN_GOAL, RECALL_GOAL = 0.4, 97.0

METHOD = """Every contact within 2 m is placed with the true pose. *False*: farther than 10 cm from
every outline. *Median* and *p90*: distance to the nearest outline over all points, false ones
included. *Recall*: of the bearings whose first obstacle is visible between 0.4 and 2 m, the share
with a contact within 10 cm of it. *Map*: occupied 5 cm cells with the odometry as recorded;
coverage is of the outline cells that were ever visible within 2 m. *Free beyond*: of the bearings
reported free, the share whose free range ends more than 10 cm behind the first outline along them:
floor that is promised where something stands. *Free way*: of the way to the first outline, or 2 m,
over all bearings, the share that is reported free. Frames stand for themselves, except that the default
detector knows feet that it saw in the last three seconds, and holds what looks as it did where it was
seen in the last six ([without](sweep.md#what-time-adds)).
Frames in which the robot stands count in the scenes that are about that (`standing`), where a detector
looks on (`default`)."""

HELD_OUT_METHOD = """Rendered for this table only: other textures, obstacles, lamps, camera heights
(0.25 to 0.60 m), frame rates and slip, among them rolling shutter with motion blur and vibration. No
parameter was chosen on them, and none should be: whoever looks at one of them to improve a figure
has to make another."""


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


def _kind_sums(results, detector):
    """kind -> visible bearings, found bearings, [(median error, weight)] over all scenes."""
    sums = {}
    for by_detector in results.values():
        for kind, row in by_detector[detector]["kinds"].items():
            entry = sums.setdefault(kind, [0, 0.0, []])
            entry[0] += row["visible_bearings"]
            entry[1] += row["recall_percent"] * row["visible_bearings"] / 100
            if row["median_error_cm"] is not None:
                entry[2].append((row["median_error_cm"], row["visible_bearings"]))
    return sums


def _mean(pairs):
    weight = sum(n for _, n in pairs)
    return sum(e * n for e, n in pairs) / weight if weight else None


def kinds_table(results, detectors):
    """Over all scenes: recall of each kind of obstacle; error of the first detector."""
    sums = {d: _kind_sums(results, d) for d in detectors}
    first = sums[detectors[0]]
    rows = []
    for kind in sorted(first):
        recalls = [100 * sums[d][kind][1] / sums[d][kind][0] if kind in sums[d] else None
                   for d in detectors]
        rows.append([kind, cell(first[kind][0]), cell(_mean(first[kind][2]))]
                    + [cell(r) for r in recalls])
    return table(["kind", "visible bearings", f"{detectors[0]}: mean of the scenes' medians, cm"]
                 + [f"{d}: recall %" for d in detectors], rows)


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


def false_goal(scene):
    return FALSE_GOAL_GLOSSY if scene in GLOSSY else FALSE_GOAL


def _verdict(value, good):
    return f"{cell(value)} ({'met' if good else '**missed**'})"


def goals_table(results, detector):
    """Each scene's figures against the goals."""
    rows = []
    for scene, by_detector in results.items():
        f = by_detector[detector]
        if is_empty(f):
            rows.append([scene, "–", "–", "–",
                         _verdict(f["contact_bearings_percent"], f["points"] == 0)])
            continue
        false, median = f["false_percent"], f["median_error_cm"]
        rows.append([scene,
                     _verdict(false, false is not None and false <= false_goal(scene)),
                     _verdict(median, median is not None and median <= MEDIAN_GOAL),
                     _verdict(f["recall_percent"], f["recall_percent"] >= RECALL_GOAL), "–"])
    return table(["scene", f"false % (≤ {FALSE_GOAL}; mirror floor ≤ {FALSE_GOAL_GLOSSY})",
                  f"median cm (≤ {MEDIAN_GOAL})", f"recall % (≥ {RECALL_GOAL:g})",
                  "empty floor % (0)"], rows)


def goals_summary(results, detector):
    """How many scenes reach each goal, in one sentence."""
    full = {s: r[detector] for s, r in results.items() if not is_empty(r[detector])}
    empty = [r[detector] for r in results.values() if is_empty(r[detector])]
    known = {s: f for s, f in full.items() if f["points"]}
    false = sum(f["false_percent"] <= false_goal(s) for s, f in known.items())
    median = sum(f["median_error_cm"] <= MEDIAN_GOAL for f in known.values())
    recall = sum(f["recall_percent"] >= RECALL_GOAL for f in full.values())
    clean = sum(f["points"] == 0 for f in empty)
    return (f"`{detector}` reaches the goal for false points in {false} of {len(full)} scenes with "
            f"obstacles, for the median error in {median}, for recall in {recall}; "
            f"{clean} of {len(empty)} empty floors stay empty.")


def split(results):
    """Scenes that everybody may look at, and those that nobody tunes on."""
    held_out = {s: r for s, r in results.items() if s.startswith(HELD_OUT)}
    return {s: r for s, r in results.items() if s not in held_out}, held_out


def held_out_section(results, detectors):
    if not results:
        return []
    parts = ["## Scenes nobody tuned on", "", HELD_OUT_METHOD, "",
             goals_summary(results, detectors[0]), "", goals_table(results, detectors[0]), "",
             empty_table(results, detectors), ""]
    for detector in detectors:
        parts += [f"### {detector}, held out", "", scenes_table(results, detector), ""]
    return parts


def findings_of(path):
    """What people wrote into a report between the two marks: kept when it is made anew."""
    if not os.path.exists(path):
        return ""
    with open(path) as file:
        text = file.read()
    if FINDINGS not in text:
        return ""
    return text.split(FINDINGS, 1)[1].split(FINDINGS_END, 1)[0].strip("\n")


def document(results, sensitivities, detectors, command, pictures, findings):
    """The whole report; pictures maps a title to a path relative to the document."""
    first = detectors[0]
    everything = results
    results, held_out = split(results)
    parts = ["# Accuracy", "", "Made by", "", "```", command, "```", "", METHOD, "",
             "## Goals", "", goals_summary(results, first), "", goals_table(results, first), "",
             FINDINGS, findings, FINDINGS_END, ""]
    parts += held_out_section(held_out, detectors)
    parts += ["## Beside the source", "", source_table(results, detectors), "",
             "## Empty floors", "", empty_table(results, detectors), "",
             "## Kinds of obstacles", "", kinds_table(everything, detectors), ""]
    for detector in detectors:
        parts += [f"## {detector}", "", scenes_table(results, detector), ""]
    if sensitivities:
        parts += ["## Sensitivity", "",
                  "The errors are those of the mounting or odometry: what is true minus what the "
                  "mapper is told.", ""]
        for sweep in sensitivities:
            parts += [sweep.table(), ""]
    for title, path in pictures.items():
        parts += [f"![{title}]({path})", ""]
    return "\n".join(parts)
