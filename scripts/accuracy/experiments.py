"""Renders scenes, runs detectors on them and scores what comes out, keeping what is up to date."""
import hashlib
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import yaml

from . import scoring

ROOT = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../.."))
SCENES = os.path.join(ROOT, "sim/scenes")
TOOLS = os.path.join(ROOT, "build/devel/lib/ipm_mapping")

# The package's detectors by name, as options of offline_mapper.
DETECTORS = {
    "default": [],
    "paper": ["--profile", "paper"],
    "chain": ["--set", "detector/kind=chain"],
    "first_architecture": ["--profile", os.path.join(ROOT, "config/first_architecture.yaml")],
    "fpga": ["--fpga"],
}


HELD_OUT = "held_out_"  # scenes with such names are nobody's to tune on

SECONDS = 8  # of a scene's drive
# The source's experiment past all of its seven obstacles; drives that turn back later.
LONGER = {"lab_normal": 17, "lab_hard": 17, "reversing": 14, "turning": 12,
          "moving_things": 14, "held_out_moving": 11, "standing": 21, "held_out_standing": 18}

# Drives that are about what happens while the robot stands: those frames count as well.
STANDING = ("standing", "held_out_standing")


def scene_path(scene):
    return os.path.join(SCENES, scene + ".yaml")


def scene_files(path):
    """A scene's file and those that it is based on, itself first."""
    files = [path]
    while True:
        with open(files[-1]) as file:
            base = yaml.safe_load(file).get("base")
        if base is None:
            return files
        files.append(os.path.join(os.path.dirname(files[-1]), base))


def scene_entry(scene, name):
    """A top-level entry of a scene, from the nearest file that has it."""
    for path in scene_files(scene_path(scene)):
        with open(path) as file:
            entries = yaml.safe_load(file)
        if name in entries:
            return entries[name]
    raise KeyError(f"{scene} has no {name}")


def frames_of(scene):
    return round(LONGER.get(scene, SECONDS) * scene_entry(scene, "rate"))


class Case:
    """A scene with changes, and how many frames of its drive are rendered (0: all); `path` is the
    file of one that is not in sim/scenes."""

    def __init__(self, scene, changes=(), frames=0, path=None):
        self.scene, self.changes, self.frames = scene, list(changes), frames
        tag = hashlib.sha256("\0".join(self.changes).encode()).hexdigest()[:8]
        self.label = f"{scene}-{frames or 'all'}" + (f"-{tag}" if self.changes else "")
        self.path = path or scene_path(scene)
        self.stands = scene in STANDING
        if not os.path.exists(self.path):
            sys.exit(f"accuracy_report: no scene {self.path}")

    def options(self):
        words = [word for change in self.changes for word in ("--set", change)]
        return words + (["--frames", str(self.frames)] if self.frames else [])


def _stamp(words, files):
    """Hash of a command and of the files it depends on."""
    digest = hashlib.sha256("\0".join(words).encode())
    for path in files:
        with open(path, "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()


def _run(words, good=(0,)):
    """What a command says; everything ends unless its exit code is good."""
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode not in good:
        sys.exit(f"accuracy_report: {' '.join(words)} failed:\n{done.stdout}")
    return done.stdout


def _up_to_date(marker, stamp):
    if not os.path.exists(marker):
        return False
    with open(marker) as file:
        return file.read() == stamp


def _do_once(words, files, marker, said=os.devnull, good=(0,)):
    """Runs a command unless the same one already made the same thing of the same files; `said`
    keeps what it prints."""
    stamp = _stamp(words, files)
    if _up_to_date(marker, stamp):
        return
    if os.path.exists(marker):
        os.remove(marker)
    with open(said, "w") as file:
        file.write(_run(words, good))
    with open(marker, "w") as file:
        file.write(stamp)


def libraries():
    """What the tools are made of, besides themselves."""
    folder = os.path.dirname(os.path.dirname(TOOLS))
    return sorted(os.path.join(folder, "lib", name) for name in os.listdir(folder + "/lib")
                  if name.startswith("libipm_mapping") and name.endswith(".so"))


class Bench:
    """Folder in which bags and runs are kept."""

    def __init__(self, folder):
        self.folder = folder
        for tool in ("sim_to_bag", "offline_mapper", "check_camera"):
            if not os.path.exists(os.path.join(TOOLS, tool)):
                sys.exit(f"accuracy_report: {tool} is not built: run scripts/build")
        simulator = [path for path in libraries() if "_sim" in path]
        self.render_files = [os.path.join(TOOLS, "sim_to_bag")] + simulator
        others = [path for path in libraries() if path not in simulator]
        self.map_files = [os.path.join(TOOLS, "offline_mapper")] + others
        self.check_files = [os.path.join(TOOLS, "check_camera")] + others

    def bag(self, case):
        """Path of the case's bag and of its truth."""
        os.makedirs(os.path.join(self.folder, "bags"), exist_ok=True)
        base = os.path.join(self.folder, "bags", case.label)
        words = [os.path.join(TOOLS, "sim_to_bag"), case.path, base + ".bag"] + case.options()
        _do_once(words, self.render_files + scene_files(case.path), base + ".stamp")
        return base + ".bag", base + ".truth.json"

    def run(self, case, detector, settings=()):
        """Folder of one detector's run on one case; settings are further options."""
        bag, truth = self.bag(case)
        tag = hashlib.sha256("\0".join(settings).encode()).hexdigest()[:8]
        name = "-".join([case.label, detector] + ([tag] if settings else []))
        out = os.path.join(self.folder, "runs", name)
        words = [os.path.join(TOOLS, "offline_mapper"), bag, "--out", out, "--truth", truth]
        words += (["--standing"] if case.stands else []) + DETECTORS[detector]
        words += [w for s in settings for w in ("--set", s)]
        os.makedirs(out, exist_ok=True)
        _do_once(words, self.map_files + [bag], os.path.join(out, "stamp"))
        return out

    def check(self, case, settings):
        """What check_camera says about a case, be it that there is too little to judge."""
        bag, _ = self.bag(case)
        tag = hashlib.sha256("\0".join(settings).encode()).hexdigest()[:8]
        out = os.path.join(self.folder, "checks", f"{case.label}-{tag}")
        words = [os.path.join(TOOLS, "check_camera"), bag, "--out", out]
        words += [w for s in settings for w in ("--set", s)]
        os.makedirs(out, exist_ok=True)
        marker, said = os.path.join(out, "stamp"), os.path.join(out, "said.txt")
        _do_once(words, self.check_files + [bag], marker, said, good=(0, 3))
        with open(said) as file:
            return file.read()

    def prepare(self, work, jobs):
        """Bags, then runs, of (case, detector, settings); `jobs` programs at a time."""
        cases = {case.label: case for case, _, _ in work}
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(self.bag, cases.values()))
            list(pool.map(lambda one: self.run(*one), work))

    def figures(self, case, detector, settings=()):
        """Figures of one detector on one case."""
        out = self.run(case, detector, settings)
        figures = scoring.score(scoring.Truth(self.bag(case)[1]), scoring.Run(out))
        with open(os.path.join(out, "report.json")) as file:
            figures["report"] = json.load(file)
        return figures


def scene_names():
    return sorted(name[:-5] for name in os.listdir(SCENES) if name.endswith(".yaml"))
