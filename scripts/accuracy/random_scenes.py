"""Scenes out of a hat: rooms, things, lamps, cameras and drives drawn at random, so that there is
always one more that nobody has seen. The same number draws the same scene, on any machine.

Lengths in metres, angles in radians; entries as in sim/include/ipm_mapping_sim/scene.hpp.
"""
import math
import random

CLEAR = 0.32  # between the robot's way and whatever stands there
APART = 0.06  # between two things
TRIES = 60  # places looked at for a thing before it is left out

POLISHED = (0.08, 0.2)  # reflection of a floor that mirrors

ROOMS = ("office", "home", "kitchen", "corridor", "hall", "lab")


def _material(draw, albedo, grains, contrast=(0.12, 0.4)):
    if draw.random() < 0.12:
        return {"albedo": round(draw.uniform(*albedo), 3), "grain": "none"}
    return {"albedo": round(draw.uniform(*albedo), 3), "grain": draw.choice(grains),
            "grain_contrast": round(draw.uniform(*contrast), 3),
            "grain_size": round(draw.uniform(0.2, 1.0), 2)}


def _carton(draw):
    return {"albedo": round(draw.uniform(0.28, 0.45), 3), "grain": "fibre", "grain_contrast": 0.14,
            "grain_size": 0.4, "pattern": "carton", "pattern_albedo": 0.6,
            "pattern_period": round(draw.uniform(0.25, 0.5), 2)}


def _bands(draw):
    return {"albedo": round(draw.uniform(0.2, 0.35), 3), "grain": "clouds", "grain_contrast": 0.12,
            "pattern": "bands", "pattern_albedo": round(draw.choice((0.08, 0.85)), 2),
            "pattern_period": round(draw.uniform(0.2, 0.32), 2)}


def _sizes(draw, **ranges):
    return {key: round(draw.uniform(*span), 3) for key, span in ranges.items()}


# What a thing looks like: functions of the draw.
THINGS = {
    "carton": lambda d: {"kind": "box", **_sizes(d, lx=(0.2, 0.5), ly=(0.2, 0.5), h=(0.12, 0.45)),
                         "material": _carton(d)},
    "crate": lambda d: {"kind": "box", **_sizes(d, lx=(0.25, 0.6), ly=(0.25, 0.6), h=(0.15, 0.6)),
                        "material": _material(d, (0.1, 0.55), ("wood", "marble", "clouds", "fibre"))},
    "bin": lambda d: {"kind": "cylinder", **_sizes(d, r=(0.09, 0.18), h=(0.22, 0.5)),
                      "material": _material(d, (0.06, 0.5), ("speckle", "clouds", "fibre"))},
    "bottle": lambda d: {"kind": "cylinder", **_sizes(d, r=(0.03, 0.05), h=(0.1, 0.32)),
                         "material": _material(d, (0.1, 0.6), ("speckle", "clouds"))},
    "chair": lambda d: {"kind": "legs", **_sizes(d, lx=(0.38, 0.46), ly=(0.38, 0.46), h=(0.42, 0.48),
                                                 leg=(0.025, 0.045), back=(0.3, 0.5)),
                        "material": _material(d, (0.06, 0.45), ("wood", "speckle"))},
    "table": lambda d: {"kind": "legs", **_sizes(d, lx=(0.5, 1.2), ly=(0.5, 0.8), h=(0.4, 0.75),
                                                 leg=(0.04, 0.07)),
                        "material": _material(d, (0.1, 0.5), ("wood", "clouds"))},
    "bag": lambda d: {"kind": "heap", **_sizes(d, lx=(0.28, 0.5), ly=(0.24, 0.42), h=(0.15, 0.42)),
                      "material": _material(d, (0.12, 0.5), ("clouds", "fibre", "marble"))},
    "low_box": lambda d: {"kind": "box", **_sizes(d, lx=(0.18, 0.4), ly=(0.12, 0.3), h=(0.035, 0.1)),
                          "material": _material(d, (0.15, 0.55), ("clouds", "wood", "fibre"))},
    "cupboard": lambda d: {"kind": "box", **_sizes(d, lx=(0.5, 1.6), ly=(0.35, 0.6), h=(0.6, 1.8)),
                           "material": _material(d, (0.15, 0.55), ("wood", "clouds"))},
    "cone": lambda d: {"kind": "cone", **_sizes(d, r=(0.12, 0.18), h=(0.35, 0.55)),
                       "material": _bands(d)},
    "drum": lambda d: {"kind": "cylinder", **_sizes(d, r=(0.25, 0.3), h=(0.6, 0.9)),
                       "material": _bands(d)},
    "pallet": lambda d: {"kind": "pallet", "lx": 1.2, "ly": 0.8, "h": 0.144,
                         "material": _material(d, (0.3, 0.45), ("wood",), (0.25, 0.4))},
    "rack": lambda d: {"kind": "shelf", "lx": 2.0, "ly": 0.8, "h": 2.0, "leg": 0.08,
                       "material": _material(d, (0.12, 0.3), ("clouds",))},
}

ROOM_THINGS = {
    "office": ("carton", "crate", "bin", "chair", "chair", "table", "bag", "cupboard", "low_box"),
    "home": ("crate", "bottle", "chair", "table", "bag", "bag", "cupboard", "low_box", "bin"),
    "kitchen": ("bin", "chair", "table", "bag", "bottle", "crate", "cupboard"),
    "corridor": ("carton", "bin", "bottle", "cupboard", "bag", "crate"),
    "hall": ("pallet", "drum", "cone", "carton", "crate", "rack", "cone"),
    "lab": ("carton", "bin", "chair", "table", "bag", "crate", "bottle"),
}
AGAINST_A_WALL = ("cupboard", "rack")


def _tiles(draw, side):
    side = round(draw.uniform(*side), 2)
    return {"grain": draw.choice(("speckle", "clouds", "marble")),
            "grain_contrast": round(draw.uniform(0.06, 0.2), 3),
            "grain_size": round(draw.uniform(0.4, 0.9), 2), "cell_x": side, "cell_y": side,
            "gap": round(draw.uniform(0.003, 0.007), 4),
            "gap_albedo": round(draw.uniform(0.1, 0.25), 2),
            "vary": round(draw.uniform(0.02, 0.12), 3), "tilt": round(draw.uniform(0, 0.002), 4)}


def _boards(draw):
    return {"grain": "wood", "grain_contrast": round(draw.uniform(0.15, 0.35), 3),
            "grain_size": round(draw.uniform(0.9, 1.4), 2), "cell_x": 1.2,
            "cell_y": round(draw.uniform(0.09, 0.18), 3), "stagger": 1.0, "gap": 0.0025,
            "gap_albedo": 0.06, "vary": round(draw.uniform(0.08, 0.18), 3), "tilt": 0.001}


def _carpet(draw):
    floor = {"grain": "fibre", "grain_contrast": round(draw.uniform(0.2, 0.4), 3),
             "grain_size": round(draw.uniform(0.3, 0.6), 2)}
    if draw.random() < 0.5:
        floor.update(cell_x=0.5, cell_y=0.5, gap=0.002, gap_albedo=0.15, vary=0.1)
    return floor


def _vinyl(draw):
    return {"grain": draw.choice(("fibre", "speckle")),
            "grain_contrast": round(draw.uniform(0.09, 0.2), 3), "grain_size": 0.5}


def _concrete(draw):
    return {"grain": "concrete", "grain_contrast": round(draw.uniform(0.15, 0.25), 3),
            "grain_size": round(draw.uniform(1.2, 1.8), 2), "blotch_contrast": 0.15,
            "blotch_size": 3.5}


ROOM_FLOORS = {
    "office": (_carpet, _vinyl),
    "home": (_boards, _carpet),
    "kitchen": (lambda d: _tiles(d, (0.12, 0.3)),),
    "corridor": (_vinyl, lambda d: _tiles(d, (0.3, 0.6))),
    "hall": (_concrete,),
    "lab": (lambda d: _tiles(d, (0.3, 0.5)), _vinyl),
}


def _floor(draw, room):
    floor = draw.choice(ROOM_FLOORS[room])(draw)
    floor["albedo"] = round(draw.uniform(0.22, 0.5), 3)
    floor["yaw"] = round(draw.uniform(-0.8, 0.8), 3)
    shine = draw.random()
    if floor["grain"] == "fibre" and room != "corridor":
        shine = 0.0
    if shine > 0.75:
        floor.update(reflection=round(draw.uniform(*POLISHED), 3),
                     specular=round(draw.uniform(0.3, 0.8), 2), shininess=200.0)
    elif shine > 0.3:
        floor.update(reflection=round(draw.uniform(0.01, 0.04), 3),
                     specular=round(draw.uniform(0.05, 0.2), 2), shininess=50.0)
    return floor


def _camera(draw):
    z = round(math.exp(draw.uniform(math.log(0.18), math.log(0.65))), 3)
    focal = round(draw.uniform(330, 600), 1)
    bend = draw.uniform(-0.22, -0.12) if focal < 420 else draw.uniform(0.0, 0.1)
    lens = [round(bend, 3), round(-0.25 * bend if bend < 0 else -2.0 * bend, 3),
            round(draw.uniform(-5e-4, 5e-4), 5), round(draw.uniform(-5e-4, 5e-4), 5), 0.0]
    # A low camera looks ahead; one high up looks down to see what is near.
    pitch = draw.uniform(0.0, 0.25) + 0.55 * z
    return {"width": 640, "height": 480, "fx": focal, "fy": focal,
            "cx": round(draw.uniform(310, 330), 1), "cy": round(draw.uniform(232, 248), 1),
            "x": round(draw.uniform(0.0, 0.15), 3), "y": round(draw.uniform(-0.02, 0.02), 3), "z": z,
            "pitch": round(pitch, 3), "distortion": lens}


def _sensor(draw):
    sensor = {"vignetting": round(draw.uniform(0.1, 0.25), 2),
              "drift": round(draw.uniform(0, 0.03), 3),
              "full_well": round(draw.uniform(4500, 9000)),
              "flicker": round(draw.uniform(0, 0.006), 4)}
    if draw.random() < 0.25:  # a cheap one
        sensor.update(exposure_time=0.008, blur_samples=3,
                      readout_time=round(draw.uniform(0.01, 0.03), 3))
    return sensor


def _lamps(draw, length):
    size = draw.choice((0.0, 0.4, 0.8))
    xs = [x + draw.uniform(-0.5, 0.5) for x in (1.0, length / 2 + 1.0, length + 1.0)]
    return [{"at": [round(x, 2), round(draw.uniform(-0.9, 0.9), 2),
                    round(draw.uniform(2.3, 2.8), 2)],
             "energy": round(draw.uniform(0.35, 0.6), 2), "size": size} for x in xs]


def _drive(draw):
    v = round(draw.uniform(0.2, 0.4), 2)
    turn = draw.choice((0.05, 0.1, 0.3))
    segments, heading = [{"seconds": 1.5, "v": v, "w": 0.0}], 0.0
    while sum(s["seconds"] for s in segments) < 9.0:
        w = round(draw.uniform(0.4, 1.0) * turn * (-1 if heading > 0 else 1), 3)
        seconds = round(draw.uniform(0.8, 2.0), 1)
        segments.append({"seconds": seconds, "v": v, "w": w})
        heading += w * seconds
    return segments


def _way(drive):
    """Places of the robot along its drive, every 2 to 4 cm."""
    x = y = heading = 0.0
    places = [(x, y)]
    for segment in drive:
        steps = max(1, round(segment["seconds"] / 0.1))
        for _ in range(steps):
            heading += segment["w"] * segment["seconds"] / steps
            x += segment["v"] * segment["seconds"] / steps * math.cos(heading)
            y += segment["v"] * segment["seconds"] / steps * math.sin(heading)
            places.append((x, y))
    return places


def _reach(thing):
    """Radius of the circle around a thing's middle that holds it."""
    return thing["r"] if "r" in thing else math.hypot(thing["lx"], thing["ly"]) / 2


def _put(draw, name, thing, way, room, taken):
    """Gives a thing a place beside the way; False if none was found."""
    reach, (end, side) = _reach(thing), room
    for _ in range(TRIES):
        x = draw.uniform(1.1, way[-1][0] + 1.3)
        left = draw.choice((-1, 1))
        if name in AGAINST_A_WALL:
            y, yaw = left * (side - thing["ly"] / 2 - 0.08), 0.0
        else:
            y, yaw = left * draw.uniform(0.0, side - reach - 0.1), draw.uniform(-1.5, 1.5)
        inside = (abs(y) + (thing["ly"] / 2 if name in AGAINST_A_WALL else reach) < side
                  and x + reach < end - 0.1)
        near = min(math.dist((x, y), place) for place in way)
        if not inside or near < reach + CLEAR:
            continue
        if any(math.dist((x, y), at) < reach + other + APART for at, other in taken):
            continue
        thing.update(name=name, x=round(x, 3), y=round(y, 3), yaw=round(yaw, 3))
        taken.append(((x, y), reach))
        return True
    return False


def _paint(draw, way, side):
    albedo = draw.choice((0.08, 0.65))
    lines = [{"kind": "line", "from": [-2, y], "to": [way[-1][0] + 4, y], "width": 0.1,
              "albedo": albedo, "wear": 0.3} for y in (round(0.7 * side, 2), round(-0.7 * side, 2))]
    for _ in range(draw.randint(1, 3)):
        lines.append({"kind": "patch", "x": round(draw.uniform(1, way[-1][0] + 1), 2),
                      "y": round(draw.uniform(-0.6, 0.6), 2), "yaw": round(draw.uniform(-1, 1), 2),
                      "lx": round(draw.uniform(0.2, 0.7), 2),
                      "ly": round(draw.uniform(0.2, 0.5), 2),
                      "albedo": draw.choice((0.08, 0.12, 0.6)),
                      "wear": round(draw.uniform(0.1, 0.4), 2)})
    return lines


def _things(draw, kind, way, room):
    things, taken = [], []
    for name in draw.sample(ROOM_THINGS[kind], k=draw.randint(4, len(ROOM_THINGS[kind]))):
        thing = THINGS[name](draw)
        if _put(draw, name, thing, way, room, taken):
            things.append(thing)
    return things


def _walls(end, side):
    """Ahead, on the left and on the right; behind the robot it is open."""
    near, far, left, right = -1.2, round(end, 2), round(side, 2), round(-side, 2)
    return [{"from": [far, right], "to": [far, left]}, {"from": [near, left], "to": [far, left]},
            {"from": [near, right], "to": [far, right]}]


def _odometry(draw):
    return {"scale": round(draw.uniform(-0.015, 0.015), 4),
            "yaw_bias": round(draw.uniform(-0.003, 0.003), 4),
            "speed_noise": 0.005, "turn_noise": 0.006}


def _begin(number):
    """The draw of a number, and the kind of room that comes first out of it."""
    draw = random.Random(number)
    return draw, draw.choice(ROOMS)


def room(number):
    """Which of ROOMS a scene is: no entry of its YAML."""
    return _begin(number)[1]


def is_polished(made):
    return made["floor"].get("reflection", 0.0) >= POLISHED[0]


def scene(number):
    """Entries of a scene, ready for YAML. Whoever changes the order of the draws changes every
    scene."""
    draw, kind = _begin(number)
    drive = _drive(draw)
    way = _way(drive)
    widest, length = max(abs(y) for _, y in way), way[-1][0]
    side = widest + (draw.uniform(0.85, 1.1) if kind == "corridor" else draw.uniform(1.3, 2.2))
    end = length + draw.uniform(1.0, 2.2)
    things = _things(draw, kind, way, (end, side))
    made = {
        "name": f"random_{number}", "seed": number, "rate": draw.choice((10, 15, 20)),
        "ambient": round(draw.uniform(0.2, 0.4), 2), "ceiling": round(draw.uniform(0.5, 0.85), 2),
        "camera": _camera(draw), "sensor": _sensor(draw), "floor": _floor(draw, kind),
        "lamps": _lamps(draw, length), "obstacles": things, "walls": _walls(end, side),
        "odometry": _odometry(draw), "drive": drive,
    }
    if kind == "hall" or draw.random() < 0.15:
        made["paint"] = _paint(draw, way, side)
    return made
