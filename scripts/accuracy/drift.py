"""How far a trajectory drifts from the true one: wheel odometry alone, and refined on the floor.

Lengths in metres, angles in radians. Everything is relative to the first frame, where both
trajectories start.
"""
import csv
import os

import numpy as np

STRETCH = 1.0  # metres of true way over which drift is taken


def compose(a, b):
    """Poses (..., 3) of b, given in the frames a (..., 3)."""
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    turn = a[..., 2] + b[..., 2]
    return np.stack([a[..., 0] + c * b[..., 0] - s * b[..., 1],
                     a[..., 1] + s * b[..., 0] + c * b[..., 1],
                     (turn + np.pi) % (2 * np.pi) - np.pi], -1)


def inverse(a):
    c, s = np.cos(a[..., 2]), np.sin(a[..., 2])
    return np.stack([-c * a[..., 0] - s * a[..., 1], s * a[..., 0] - c * a[..., 1], -a[..., 2]], -1)


def between(a, b):
    """Poses b in the frames a."""
    return compose(inverse(a), b)


class Trajectory:
    """What offline_mapper wrote as trajectory.csv: poses (n, 3), covariances (n, 3, 3)."""

    def __init__(self, folder):
        with open(os.path.join(folder, "trajectory.csv")) as file:
            rows = list(csv.DictReader(file))
        if not rows:
            raise ValueError(f"{folder}/trajectory.csv has no frames")
        column = {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
        self.stamps = column["stamp"]
        self.odometry, self.refined = (
            np.stack([column[axis + kind] for axis in ("x", "y", "theta")], 1)
            for kind in ("_odom", "_refined"))
        xx, xy, xt, yy, yt, tt = (column[key] for key in (
            "var_x", "cov_xy", "cov_xtheta", "var_y", "cov_ytheta", "var_theta"))
        self.covariance = np.stack([np.stack(row, 1) for row in (
            (xx, xy, xt), (xy, yy, yt), (xt, yt, tt))], 1)


def way(poses):
    """Metres gone up to each pose."""
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def rms(values):
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else None


def drift(true, poses):
    """Error at the end, and over every stretch of STRETCH metres: mm, mrad, root mean square."""
    end = between(between(true[0], true[-1]), between(poses[0], poses[-1]))
    gone = way(true)
    first = np.nonzero(gone + STRETCH <= gone[-1])[0]
    last = np.searchsorted(gone, gone[first] + STRETCH)
    error = between(between(true[first], true[last]), between(poses[first], poses[last]))
    per_metre = rms(np.hypot(error[:, 0], error[:, 1]))
    turned = rms(error[:, 2])
    return {"end_mm": 1e3 * float(np.hypot(*end[:2])), "end_mrad": 1e3 * abs(float(end[2])),
            "mm_per_m": per_metre and 1e3 * per_metre, "mrad_per_m": turned and 1e3 * turned}


def sigmas(true, trajectory):
    """Root mean square of the refined poses' errors in their own standard deviations: 1 is honest,
    more is too sure. sqrt(error' covariance^-1 error / 3), axes of the odometry's frame."""
    start = compose(trajectory.refined[0], inverse(true[0]))
    error = trajectory.refined - compose(start[None], true)
    error[:, 2] = (error[:, 2] + np.pi) % (2 * np.pi) - np.pi
    moved = np.linalg.matrix_rank(trajectory.covariance) == 3
    solved = np.linalg.solve(trajectory.covariance[moved], error[moved, :, None])[..., 0]
    return rms(np.sqrt((error[moved] * solved).sum(1) / 3.0)) if moved.any() else None


def figures(truth, trajectory):
    """Way in metres, drift of odometry and of the refined trajectory, and the latter's sigmas."""
    if truth.start is None:
        truth.start = trajectory.stamps[0]
    true = np.array([truth.pose(stamp) for stamp in trajectory.stamps])
    return {"way_m": float(way(true)[-1]), "odometry": drift(true, trajectory.odometry),
            "refined": drift(true, trajectory.refined), "sigmas": sigmas(true, trajectory)}
