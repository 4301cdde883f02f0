"""A camera that is not where it is said to be: what check_camera finds, and what contacts become of
it without and with self-calibration."""
import math
import re
from concurrent.futures import ThreadPoolExecutor

from . import drift, scoring, tables

DEGREE = math.pi / 180
MOUNTING = ("x", "y", "z", "pitch")
APPLY = "calibration/mode=apply"

# Stated minus true: pitch in degrees, height in cm.
CHECKED = {"true": (0, 0), "+1°": (1, 0), "−1°": (-1, 0), "+3 cm": (0, 3), "−3 cm": (0, -3)}
PITCH_GOAL, HEIGHT_GOAL = 0.2, 1.0
APPLIED = {"+": (1, 2), "−": (-1, -2)}

FIGURES = [("false_percent", "false %"), ("median_error_cm", "median cm"),
           ("p90_error_cm", "p90 cm"), ("recall_percent", "recall %")]
SETTLING = 1.2  # metres of way after which self-calibration is expected to have settled
# Worse than at the true pose: by more than a share, and by more than 0.2 % or 2 mm.
WORSE_SHARE, WORSE = 0.2, 0.2


class Camera:
    """Where a scene's camera really is."""

    def __init__(self, truth):
        self.x, self.y, self.z = truth.place
        self.pitch = truth.camera["pitch"] + truth.camera.get("pitch_error", 0.0)

    def stated(self, pitch_error, height_error):
        """Settings that state it so many degrees and cm off."""
        pose = (self.x, self.y, self.z + 0.01 * height_error, self.pitch + DEGREE * pitch_error)
        return ("camera/pose_from_tf=false",
                *(f"camera/{key}={value:.6g}" for key, value in zip(MOUNTING, pose)))


def camera_of(case, bench):
    return Camera(scoring.Truth(bench.bag(case)[1]))


def estimate(text):
    """Pitch in degrees and height in metres that check_camera printed; None: it refused."""
    found = [re.search(rf"^{key}: (-?[\d.]+)", text, re.MULTILINE)
             for key in ("pitch_deg", "height_m")]
    return [float(each.group(1)) for each in found] if all(found) else None


def check_errors(case, bench, errors):
    """How far off check_camera's pitch (degrees) and height (cm) are; None: it refused."""
    camera = camera_of(case, bench)
    found = estimate(bench.check(case, camera.stated(*errors)))
    if found is None:
        return None
    return found[0] - camera.pitch / DEGREE, 100 * (found[1] - camera.z)


def is_found(errors):
    return errors is not None and abs(errors[0]) <= PITCH_GOAL and abs(errors[1]) <= HEIGHT_GOAL


def check_cell(errors):
    if errors is None:
        return "refused"
    text = f"{errors[0]:+.2f} / {errors[1]:+.2f}".replace("-", "−")
    return text if is_found(errors) else f"**{text}**"


def check_row(case, bench):
    truth = scoring.Truth(bench.bag(case)[1])
    odometry = f"{100 * truth.scene['odometry']['scale']:+.1f}".replace("-", "−")
    return [f"`{case.scene}`", f"{truth.place[2]:.2f}", odometry,
            *(check_cell(check_errors(case, bench, errors)) for errors in CHECKED.values())]


def check_table(cases, bench, jobs):
    with ThreadPoolExecutor(jobs) as pool:
        rows = list(pool.map(lambda case: check_row(case, bench), cases))
    return tables.table(["pitch ° / height cm", "height m", "odometry %", *CHECKED], rows)


def runs(case, bench, errors):
    """Settings of the three runs that a row compares: true pose, stated wrongly, and corrected."""
    camera = camera_of(case, bench)
    wrong = camera.stated(*errors)
    return camera.stated(0, 0), wrong, (*wrong, APPLY)


def settled_at(truth):
    """Stamp at which the robot has gone far enough for the calibration to have settled."""
    gone = drift.way(truth.poses[:, 1:])
    late = truth.poses[gone >= SETTLING, 0]
    return truth.start + (late[0] if len(late) else math.inf)


def figures(case, bench, settings, settled):
    truth = scoring.Truth(bench.bag(case)[1])
    run = scoring.Run(bench.run(case, "default", settings))
    return scoring.score(truth, run.since(settled_at(truth)) if settled else run)


def is_recovered(key, true, applied):
    """No figure is worse than at the true pose by more than its share."""
    if true is None or applied is None:
        return true is None
    loss = true - applied if key == "recall_percent" else applied - true
    return loss <= max(WORSE, WORSE_SHARE * abs(true))


def lost(true, applied):
    """Titles of the figures that are not recovered."""
    return [title for key, title in FIGURES if not is_recovered(key, true[key], applied[key])]


def apply_cell(key, three):
    words = [tables.cell(figure[key]) for figure in three]
    if not is_recovered(key, three[0][key], three[2][key]):
        words[2] = f"**{words[2]}**"
    return " / ".join(words)


def label(case):
    return ", ".join([f"`{case.scene}`", *(f"`{change}`" for change in case.changes)])


def apply_row(case, sign, bench, settled):
    three = [figures(case, bench, settings, settled)
             for settings in runs(case, bench, APPLIED[sign])]
    if tables.is_empty(three[0]):
        return None
    return [f"{label(case)} {sign}", *(apply_cell(key, three) for key, _ in FIGURES)]


def apply_table(cases, bench, settled):
    rows = [apply_row(case, sign, bench, settled) for case in cases for sign in APPLIED]
    return tables.table(["true / stated wrongly / applied", *(title for _, title in FIGURES)],
                        [row for row in rows if row])
