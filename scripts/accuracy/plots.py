"""The report's pictures."""
import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from .tables import is_empty  # noqa: E402

BARS = [("false_percent", "false contacts, %"), ("recall_percent", "recall, %"),
        ("median_error_cm", "median error, cm"), ("map_coverage_percent", "map coverage, %")]
CURVES = [("false_percent", "false, %"), ("median_error_cm", "median, cm"),
          ("recall_percent", "recall, %")]


def _save(figure, folder, name):
    path = os.path.join(folder, "accuracy_" + name)
    figure.savefig(path, dpi=90, bbox_inches="tight")
    plt.close(figure)
    return path


def scenes(results, detectors, folder):
    shown = [s for s, by_detector in results.items() if not is_empty(by_detector[detectors[0]])]
    figure, axes = plt.subplots(len(BARS), 1, figsize=(11, 2.6 * len(BARS)), sharex=True)
    width = 0.8 / len(detectors)
    for axis, (key, title) in zip(axes, BARS):
        for k, detector in enumerate(detectors):
            heights = [results[s][detector].get(key) or 0.0 for s in shown]
            axis.bar([i + (k + 0.5) * width - 0.4 for i in range(len(shown))], heights, width,
                     label=detector)
        axis.set_ylabel(title)
        axis.grid(axis="y", alpha=0.4)
    axes[0].legend(ncol=len(detectors))
    axes[-1].set_xticks(range(len(shown)))
    axes[-1].set_xticklabels(shown, rotation=40, ha="right")
    return _save(figure, folder, "scenes.png")


def sensitivity(sweep, folder):
    figure, axes = plt.subplots(1, len(CURVES), figsize=(12, 3))
    for axis, (key, title) in zip(axes, CURVES):
        for detector, series in sweep.figures.items():
            heights = [figures[key] if figures[key] is not None else float("nan")
                       for figures in series]
            axis.plot(sweep.values, heights, "o-", label=detector)
        axis.set_ylim(bottom=0)
        axis.set_xlabel(f"{sweep.title}, {sweep.unit}")
        axis.set_ylabel(title)
        axis.grid(alpha=0.4)
    axes[0].legend()
    return _save(figure, folder, sweep.title.replace(" ", "_") + ".png")
