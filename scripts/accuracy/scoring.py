"""How well a run of offline_mapper agrees with a scene's ground truth.

All lengths in metres. Contacts are placed with the true pose, so that odometry's drift is not the
detector's fault; the map is taken as it was made, with the odometry as recorded.
"""
import copy
import csv
import json
import math
import os

import numpy as np

TOLERANCE = 0.10  # a contact this near to an outline is right
NEAR, FAR = 0.40, 2.00  # ranges that count
LOW = 0.015  # lower things are no obstacles
MOVING = "moving"  # kind of what goes a way
CELL = 0.05  # of the outline, for the map's coverage
RAYS = 64  # bearings asked for in each frame
MARGIN = 8  # pixels from the image's border within which nothing is asked for


class Truth:
    """Outlines, poses and camera of a scene."""

    def __init__(self, path):
        with open(path) as file:
            data = json.load(file)
        self.scene = data["scene"]
        self.camera = self.scene["camera"]
        self.place = np.array(data["camera_in_robot"]["translation"], float)
        self.poses = np.array(data["poses"], float).reshape(-1, 4)
        self.start = data.get("bag_start")
        obstacles = [f for f in data["footprints"] if f["height"] >= LOW]
        self.solids = [np.array(f["polygon"], float) for f in data["footprints"] if "polygon" in f]
        starts, ends, self.kinds, self.ways = [], [], [], []
        self.solid_ways = [f.get("way") for f in data["footprints"] if "polygon" in f]
        for footprint in obstacles:
            points = footprint.get("polygon") or footprint["polyline"]
            closed = "polygon" in footprint
            follow = points[1:] + points[:1] if closed else points[1:]
            for a, b in zip(points, follow):
                starts.append(a)
                ends.append(b)
                kind = footprint.get("kind") or footprint["name"]
                self.kinds.append(MOVING if footprint.get("way") else kind)
                self.ways.append(footprint.get("way"))
        self.a = np.array(starts, float).reshape(-1, 2)
        self.b = np.array(ends, float).reshape(-1, 2)
        self.moving = np.array([way is not None for way in self.ways], bool)

    def at(self, stamp):
        """This scene with moving things where they are at a stamp."""
        if not self.moving.any():
            return self
        now = copy.copy(self)
        gone = np.array([self._gone(way, stamp) for way in self.ways]).reshape(-1, 2)
        now.a, now.b = self.a + gone, self.b + gone
        now.solids = [solid + self._gone(way, stamp)
                      for solid, way in zip(self.solids, self.solid_ways)]
        return now

    def _gone(self, way, stamp):
        if not way:
            return np.zeros(2)
        at, x, y = np.array(way, float).T
        t = stamp - self.start
        return np.array([np.interp(t, at, x), np.interp(t, at, y)])

    def pose(self, stamp):
        """x, y, heading at a stamp."""
        t = stamp - self.start
        return [float(np.interp(t, self.poses[:, 0], self.poses[:, k])) for k in (1, 2, 3)]

    def to_world(self, pose, points):
        """Robot coordinates (n, 2) to world coordinates."""
        x, y, heading = pose
        c, s = math.cos(heading), math.sin(heading)
        return np.asarray(points, float) @ np.array([[c, s], [-s, c]]) + [x, y]

    def nearest(self, points):
        """Distance of each point (n, 2) to the nearest outline, and that outline's index."""
        points = np.asarray(points, float).reshape(-1, 2)
        if len(self.a) == 0:
            return np.full(len(points), np.inf), np.zeros(len(points), int)
        along = self.b - self.a
        length = np.maximum((along ** 2).sum(1), 1e-12)
        t = np.clip(((points[:, None] - self.a) * along).sum(2) / length, 0, 1)
        gap = self.a + t[..., None] * along - points[:, None]
        distance = np.hypot(gap[..., 0], gap[..., 1])
        index = distance.argmin(1)
        return distance[np.arange(len(points)), index], index

    def first_outlines(self, origin, angles):
        """Distance from origin along each angle to the first outline (inf: none), and its index."""
        if len(self.a) == 0:
            return np.full(len(angles), np.inf), np.zeros(len(angles), int)
        ray = np.stack([np.cos(angles), np.sin(angles)], 1)[:, None]
        edge, offset = self.b - self.a, self.a - origin
        cross = lambda p, q: p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            across = cross(ray, edge)
            distance = cross(offset, edge) / across
            share = cross(offset, ray) / across
        ahead = (distance > 1e-6) & (share >= 0) & (share <= 1)
        distance = np.where(ahead, distance, np.inf)
        index = distance.argmin(1)
        return distance[np.arange(len(angles)), index], index

    def inside_solid(self, point):
        """The scripted drive has put the camera into an obstacle."""
        for polygon in self.solids:
            a, b = polygon, np.roll(polygon, -1, 0)
            spans = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
            if not spans.any():
                continue
            a, b = a[spans], b[spans]
            x = a[:, 0] + (point[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
            if (point[0] < x).sum() % 2:
                return True
        return False

    def in_view(self, base):
        """Which floor points (n, 2), in robot coordinates, the camera has within its image."""
        c = self.camera
        pitch = c["pitch"] + c.get("pitch_error", 0.0)
        x, y, z = base[:, 0] - self.place[0], base[:, 1] - self.place[1], -self.place[2]
        right = -y
        down = -math.sin(pitch) * x - math.cos(pitch) * z
        depth = math.cos(pitch) * x - math.sin(pitch) * z
        with np.errstate(divide="ignore", invalid="ignore"):
            u = c["fx"] * right / depth + c["cx"]
            v = c.get("fy", c["fx"]) * down / depth + c["cy"]
        return ((depth > 0.05) & (u >= MARGIN) & (u < c["width"] - MARGIN) & (v >= 0)
                & (v < c["height"] - MARGIN))


class Run:
    """What offline_mapper wrote."""

    def __init__(self, folder):
        self.points = self._rows(folder, "points.csv")
        self.bearings = self._rows(folder, "obstacles.csv")
        self.map_yaml = os.path.join(folder, "map.yaml")

    @staticmethod
    def _rows(folder, name):
        with open(os.path.join(folder, name)) as file:
            return list(csv.DictReader(file))

    def since(self, stamp):
        """This run without what came before a stamp; the map stays whole."""
        rest = copy.copy(self)
        rest.points, rest.bearings = ([row for row in rows if float(row["stamp"]) >= stamp]
                                      for rows in (self.points, self.bearings))
        return rest

    def stamps(self):
        return sorted({float(row["stamp"]) for row in self.bearings})

    def contacts(self):
        """Contacts in robot coordinates (n, 2) of each stamp."""
        by_stamp = {}
        for row in self.points:
            point = (float(row["x_base"]), float(row["y_base"]))
            by_stamp.setdefault(float(row["stamp"]), []).append(point)
        return {stamp: np.array(points) for stamp, points in by_stamp.items()}

    def bearing_table(self):
        """Angle, range and whether that range is reported free or up to a contact (n, 4) of the
        bearings of each stamp."""
        by_stamp = {}
        for row in self.bearings:
            bearing = (float(row["angle_rad"]), float(row["range_m"]), row["state"] == "free",
                       row["state"] == "occupied")
            by_stamp.setdefault(float(row["stamp"]), []).append(bearing)
        return {stamp: np.array(bearings) for stamp, bearings in by_stamp.items()}

    def occupied_cells(self):
        """Centres (n, 2) of the map's occupied cells; None without a map."""
        if not os.path.exists(self.map_yaml):
            return None
        with open(self.map_yaml) as file:
            entries = dict(line.split(":", 1) for line in file if ":" in line)
        resolution = float(entries["resolution"])
        origin = [float(v) for v in entries["origin"].strip().strip("[]").split(",")[:2]]
        image = os.path.join(os.path.dirname(self.map_yaml), entries["image"].strip())
        grid = read_pgm(image)
        rows, columns = np.nonzero(grid < 90)
        return np.stack([origin[0] + (columns + 0.5) * resolution,
                         origin[1] + (grid.shape[0] - 1 - rows + 0.5) * resolution], 1)


def read_pgm(path):
    """Binary PGM as an array; raises ValueError if it is something else."""
    with open(path, "rb") as file:
        raw = file.read()
    fields, at = [], 0
    while len(fields) < 4:
        while raw[at:at + 1].isspace():
            at += 1
        if raw[at:at + 1] == b"#":
            at = raw.index(b"\n", at)
            continue
        end = at
        while end < len(raw) and not raw[end:end + 1].isspace():
            end += 1
        fields.append(raw[at:end])
        at = end
    if fields[0] != b"P5":
        raise ValueError(f"{path} is no binary PGM")
    width, height = int(fields[1]), int(fields[2])
    return np.frombuffer(raw, np.uint8, width * height, at + 1).reshape(height, width)


def percent(part, whole):
    return 100.0 * part / whole if whole else None


class _Tally:
    """Sums over the frames of a run."""

    def __init__(self):
        self.errors, self.error_kinds = [], []
        self.asked, self.found = {}, {}
        self.visible_cells = set()
        self.free = self.free_beyond = 0
        self.free_way = self.true_way = 0.0  # metres, over all bearings


def _score_contacts(truth, contacts, pose, tally):
    near = contacts[np.hypot(contacts[:, 0], contacts[:, 1]) <= FAR] if len(contacts) else contacts
    world = truth.to_world(pose, near) if len(near) else np.zeros((0, 2))
    if len(world):
        distance, index = truth.nearest(world)
        tally.errors += distance.tolist()
        tally.error_kinds += [truth.kinds[i] if truth.kinds else "" for i in index]
    return world


def _score_bearings(truth, world, pose, tally):
    c = truth.camera
    half = 1.1 * math.atan(0.5 * c["width"] / c["fx"])
    angles = np.linspace(-half, half, RAYS)
    foot = truth.to_world(pose, [truth.place[:2]])[0]
    distance, index = truth.first_outlines(foot, pose[2] + angles)
    reached = np.where(np.isfinite(distance), distance, 0.0)
    base = truth.place[:2] + reached[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    counts = (np.isfinite(distance) & (distance >= NEAR) & (np.hypot(*base.T) <= FAR)
              & truth.in_view(base))
    targets = truth.to_world(pose, base)
    for k in np.nonzero(counts)[0]:
        kind = truth.kinds[index[k]]
        hit = len(world) > 0 and (np.hypot(*(world - targets[k]).T) <= TOLERANCE).any()
        tally.asked[kind] = tally.asked.get(kind, 0) + 1
        tally.found[kind] = tally.found.get(kind, 0) + int(hit)
        if not truth.moving[index[k]]:  # a map keeps nothing of what goes away
            tally.visible_cells.add(tuple(np.floor(targets[k] / CELL).astype(int)))


def _score_free(truth, bearings, pose, tally):
    """Free ranges that end more than the tolerance behind the first outline along them, and how
    much of the way to that outline, as far as ranges count, is free."""
    foot = truth.to_world(pose, [truth.place[:2]])[0]
    distance, _ = truth.first_outlines(foot, pose[2] + bearings[:, 0])
    free, occupied = bearings[:, 2] > 0, bearings[:, 3] > 0
    tally.free += int(free.sum())
    tally.free_beyond += int((bearings[free, 1] > distance[free] + TOLERANCE).sum())
    way = np.minimum(distance, FAR - np.hypot(*truth.place[:2]))
    tally.free_way += np.minimum(bearings[:, 1], way)[free | occupied].sum()
    tally.true_way += way.sum()


def _map_figures(truth, cells, tally):
    if cells is None:
        return {}
    false = (truth.nearest(cells)[0] > TOLERANCE).sum() if len(cells) else 0
    covered = 0
    for cell in tally.visible_cells:
        centre = (np.array(cell) + 0.5) * CELL
        covered += len(cells) > 0 and (np.hypot(*(cells - centre).T) <= TOLERANCE).any()
    return {"map_occupied_cells": len(cells), "map_false_cells_percent": percent(false, len(cells)),
            "map_coverage_percent": percent(covered, len(tally.visible_cells))}


def _kind_figures(tally):
    errors, kinds = np.array(tally.errors), np.array(tally.error_kinds)
    table = {}
    for kind in sorted(tally.asked):
        right = errors[(kinds == kind) & (errors <= TOLERANCE)] if len(errors) else errors
        table[kind] = {"visible_bearings": tally.asked[kind],
                       "recall_percent": percent(tally.found[kind], tally.asked[kind]),
                       "median_error_cm": 100 * float(np.median(right)) if len(right) else None}
    return table


def score(truth, run):
    """Every figure of a run as a dictionary; None where there is nothing to take a share of."""
    if truth.start is None:
        truth.start = min(run.stamps(), default=0.0)
    contacts, bearings = run.contacts(), run.bearing_table()
    tally = _Tally()
    used = 0
    for stamp in run.stamps():
        pose, now = truth.pose(stamp), truth.at(stamp)
        if now.inside_solid(now.to_world(pose, [now.place[:2]])[0]):
            continue
        used += 1
        world = _score_contacts(now, contacts.get(stamp, np.zeros((0, 2))), pose, tally)
        _score_bearings(now, world, pose, tally)
        _score_free(now, bearings[stamp], pose, tally)
    errors = np.minimum(np.array(tally.errors), 1.0)  # one stray point must not own the p90
    asked = sum(tally.asked.values())
    with_contact = {(row["frame"], row["bearing"]) for row in run.points}
    figures = {
        "frames_used": used,
        "points": len(errors),
        "false_percent": percent(int((errors > TOLERANCE).sum()), len(errors)),
        "median_error_cm": 100 * float(np.median(errors)) if len(errors) else None,
        "p90_error_cm": 100 * float(np.percentile(errors, 90)) if len(errors) else None,
        "visible_bearings": asked,
        "recall_percent": percent(sum(tally.found.values()), asked),
        "contact_bearings_percent": percent(len(with_contact), len(run.bearings)),
        "free_bearings": tally.free,
        "free_beyond_percent": percent(tally.free_beyond, tally.free),
        "free_way_percent": percent(tally.free_way, tally.true_way),
    }
    at_the_end = truth.at(max(run.stamps(), default=truth.start))
    figures.update(_map_figures(at_the_end, run.occupied_cells(), tally))
    figures["kinds"] = _kind_figures(tally)
    return figures
