"""Makes the pictures of README and docs from synthetic scenes: python docs/images/make.py"""

import json
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import cv2
import jax
import matplotlib.pyplot as plt
import numpy as np
import stereorecal_paper as paper
from pair_figure import Panel, repair_figure, save
from stereorecal_field.table._field_figures import coverage, error_against_seconds, harm

import stereorecal as sr
from stereorecal.estimation import points_of_view, readings
from stereorecal.geometry import changed_camera
from stereorecal.synthetic import Knock

HERE = Path(__file__).parent
_GAP = 24  # blank rows of pixels above a heading, at least
_BASELINES, _APART = 30, 2  # of motion: a distance, and pairs from the first of a window to the second


def repair() -> None:
    """A harbour before and after a repair."""
    scene = sr.synthetic.render("harbour", 0)
    bad = sr.synthetic.decalibrate(scene.rig, jax.random.key(0), 1.0, 0.01)
    solution = sr.recalibrate(bad, scene.pairs)
    print(solution)
    for name, rig in (("before", bad), ("after", solution.rig)):
        print(f"{name}, against the truth:\n{sr.difference(rig, scene.rig)}")
    panels = []
    for title, rig in (("before", bad), ("after", solution.rig)):
        images = sr.rectify(rig, scene.pairs[0], view=solution.view)
        found = sr.disparity(rig, scene.pairs[0], matcher=solution.matcher, view=solution.view)
        panels.append(Panel(title, *images, found.values, found.valid))
    save(repair_figure(panels), HERE / "repair.png")


def report() -> None:
    """The page of a repair, as a headless Chromium shows it; needs one."""
    scene = sr.synthetic.render("harbour", 0)
    bad = sr.synthetic.decalibrate(scene.rig, jax.random.key(0), 1.0, 0.01)
    with tempfile.TemporaryDirectory() as name:
        page, picture = Path(name) / "report.html", Path(name) / "report.png"
        sr.recalibrate(bad, scene.pairs).to_html(page, scene.pairs, name="harbour")
        size = ["--window-size=1000,6000", "--hide-scrollbars", f"--screenshot={picture}"]
        subprocess.run(["chromium", "--headless", "--no-sandbox", *size, page.as_uri()], check=True)
        shown = cv2.imread(str(picture))
    assert shown is not None
    blank = (shown == shown[-1, -1]).all(axis=(1, 2))
    shown = shown[: np.flatnonzero(~blank)[-1] + _GAP]
    # Side by side, since docs are wide, not long: cut at the gap above a heading that is nearest to the middle.
    gaps = [row for row in range(_GAP, len(shown) - _GAP) if blank[row - _GAP : row].all()]
    cut = min(gaps, key=lambda row: abs(row - len(shown) // 2))
    first, second = shown[:cut], shown[cut:]
    longest = max(len(first), len(second))
    halves = [np.pad(half, ((0, longest - len(half)), (0, 0), (0, 0)), constant_values=255) for half in (first, second)]
    whole = np.concatenate(halves, axis=1)
    cv2.imwrite(str(HERE / "report.jpg"), cv2.resize(whole, None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA))


def drive() -> None:
    """The error of the rig in use over a drive with knocks, with the estimate's interval, and what happened."""
    knocks = (
        Knock(30, (0.2, 0.0, 0.0)),
        Knock(80, (0.0, 0.5, 0.0)),
        Knock(130, (0.0, 0.0, -0.3)),
        Knock(170, (-1.5, 1.0, 2.0)),
        Knock(230, (2.5, -2.0, 1.0)),
    )
    taken = sr.synthetic.plan_drive("harbour", 2, 300, knocks=knocks, weather=False)
    used, found, half, happened = [], [], [], []
    for frame, stepped in enumerate(sr.online.run(taken.rig, sr.synthetic.photographs(taken))):
        truth = stepped.state.offset_of(taken.truth(frame))
        used.append(stepped.state.using - truth)
        found.append(stepped.state.offset - truth)
        half.append(1.96 * np.sqrt(np.diag(stepped.state.of_offset)))
        happened += [(frame, event.kind) for event in stepped.events]
    used, found, half = np.array(used), np.array(found), np.array(half)
    figure, rows = plt.subplots(3, 1, figsize=(9.0, 6.0), sharex=True, layout="constrained")
    for axis, (axes, name) in enumerate(zip(rows, ("pitch", "yaw", "roll"), strict=True)):
        frames = np.arange(len(used))
        low, high = found[:, axis] - half[:, axis], found[:, axis] + half[:, axis]
        axes.fill_between(frames, low, high, color="tab:blue", alpha=0.25, lw=0, label="estimate, 95 %")
        axes.plot(used[:, axis], color="black", lw=1.0, label="rig in use")
        for kind, colour in ((sr.online.Kind.KNOCK, "tab:red"), (sr.online.Kind.REPAIRED, "tab:green")):
            for number, frame in enumerate(f for f, k in happened if k is kind):
                axes.axvline(frame, color=colour, lw=0.8, label=kind.name.lower() if number == 0 else None)
        axes.set_ylim(-0.25, 0.25)
        axes.set_ylabel(f"{name}, error [deg]")
    rows[0].legend(loc="upper right", fontsize=8, ncols=4)
    rows[-1].set_xlabel("pair")
    figure.savefig(HERE / "drive.png", dpi=110)
    plt.close(figure)


def motion() -> None:
    """The offset of disparity of a calibration over a drive on which yaw is knocked: by the rows of two pairs, by their
    rows and the motion between them, and the truth."""
    taken = sr.synthetic.plan_drive("street", 3, 48, knocks=(Knock(24, (0.0, 0.25, 0.0)),), weather=False)
    pairs, given = [*sr.synthetic.photographs(taken)], taken.rig
    at = float(given.left.focal[0]) / _BASELINES  # pixels of disparity
    figure, axes = plt.subplots(figsize=(9.0, 3.6), layout="constrained")
    frames = range(0, len(pairs) - _APART, 4)
    for used, colour, name, beside in ((False, "tab:orange", "rows", -0.4), (True, "tab:blue", "rows and motion", 0.4)):
        said = []
        for frame in frames:
            some = [pairs[frame], pairs[frame + _APART]]
            seen = sr.recalibrate(given, some, motion=used).estimate
            assert seen is not None
            errors = seen.depth_error_percent(np.zeros(len(seen.names)))[_BASELINES]
            said.append([at * (1.0 / (1.0 + error / 100.0) - 1.0) for error in errors])
        middle, high, low = np.array(said).T
        where = np.array(frames) + 0.5 * _APART + beside
        axes.errorbar(where, middle, (middle - low, high - middle), fmt="o", ms=4, color=colour, label=f"{name}, 95 %")
    truth = [at * np.mean(readings(given, t, points_of_view(t, _BASELINES))[1]) for t in map(taken.truth, range(48))]
    axes.plot(truth, color="black", lw=1.0, label="truth")
    axes.set_xlabel("pair")
    axes.set_ylabel("offset of disparity [px]")
    axes.legend(fontsize=8, loc="lower left")
    figure.savefig(HERE / "motion.png", dpi=110)
    plt.close(figure)


def conventions() -> None:
    """The two camera frames in an oblique drawing, each axis with the angle that turns about it."""
    figure, axes = plt.subplots(figsize=(8.0, 3.4), layout="constrained")
    axes.set_axis_off()
    axes.set_aspect("equal")
    # x to the right, y down, z forward: away from the viewer, drawn up and to the right.
    directions = {
        "x (pitch)": ((1.0, 0.0), "#d55e00"),
        "y (yaw)": ((0.0, -1.0), "#009e73"),
        "z (roll)": ((0.75, 0.6), "#0072b2"),
    }
    for name, origin in (("left camera", (0.0, 0.0)), ("right camera", (3.0, 0.0))):
        for label, (step, colour) in directions.items():
            tip = (origin[0] + step[0], origin[1] + step[1])
            axes.annotate("", tip, origin, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.0})
            axes.text(tip[0] + 0.06, tip[1] + 0.03, label, color=colour, fontsize=11)
        axes.text(origin[0] - 0.1, origin[1] + 0.1, name, fontsize=11, ha="right")
    axes.plot([1.0, 3.0], [0.0, 0.0], linestyle="--", color="0.5", zorder=0)
    axes.text(1.75, -0.2, "baseline B", color="0.3", fontsize=11)
    axes.text(0.9, -1.0, "x_right = R x_left + T\nideal rig: R = I, T = (-B, 0, 0)", fontsize=11)
    axes.set_xlim(-1.1, 4.8)
    axes.set_ylim(-1.2, 0.8)
    save(figure, HERE / "conventions.png")


def misfit() -> None:
    """What is left of the rows of each region, for images that the model explains and for two that it does not."""
    scene = sr.synthetic.render("harbour", 0)
    (pair,) = scene.pairs
    left, right = np.array(pair.left), np.array(pair.right)
    height, width = right.shape
    moved, rolled = right.copy(), right.copy()
    moved[:-2, : int(0.3 * width)] = right[2:, : int(0.3 * width)]
    columns, rows = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    rolled = cv2.remap(right, columns, rows + 3.0 * rows / height, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
    cases = {"as it was taken": right, "left 30 % two rows later": moved, "a shutter that rolls by three rows": rolled}
    bad = sr.synthetic.decalibrate(scene.rig, jax.random.key(0), 1.0, 0.01)
    figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.4), layout="constrained")
    shown = None
    for where, (title, image) in zip(axes, cases.items(), strict=True):
        solution = sr.recalibrate(bad, [sr.Pair(left, image.astype(np.float32))])
        assert solution.misfit is not None
        regions = np.full((6, 8), np.nan)
        regions[np.divmod(solution.misfit.place, 8)] = solution.misfit.after
        where.imshow(left, cmap="gray", extent=(0, 8, 6, 0), alpha=0.6)
        shown = where.imshow(regions, cmap="coolwarm", vmin=-1, vmax=1, extent=(0, 8, 6, 0), alpha=0.7)
        where.set_title(f"{title}\n{solution.reason.name}, {solution.misfit.rms:.2f} px")
        where.set_axis_off()
        print(title, solution.reason.name)
    assert shown is not None
    figure.colorbar(shown, ax=axes, label="row difference of a region, px")
    save(figure, HERE / "misfit.png")


def yaw_and_centre() -> None:
    """A yaw, and the same yaw with the principal point that keeps depth: the same rows, other depth."""
    rig = sr.synthetic.default_rig()
    rig = replace(
        rig, left=sr.Camera(rig.left.size, rig.left.matrix), right=sr.Camera(rig.right.size, rig.right.matrix)
    )
    turn = np.radians([0.0, 0.3, 0.0, 0.0, 0.0, 0.0])
    turned = rig.with_extrinsics(rig.extrinsics + turn)
    shift = float(rig.right.matrix[0, 0]) * turn[1]
    both = replace(turned, right=changed_camera(rig.right, {"cx": -shift}))
    distances = np.linspace(4.0, 60.0, 100)
    figure, axes = plt.subplots(1, 3, figsize=(11, 2.9), layout="constrained")
    shown = None
    for where, (title, used) in zip(
        axes, {"0.3° of yaw": turned, f"the same, centre moved by {shift:.1f} px": both}.items(), strict=False
    ):
        grid = np.stack(np.meshgrid(*(np.linspace(0, n - 1, 60) for n in rig.left.size)), axis=-1).reshape(-1, 2)
        points = np.asarray(rig.left.rays(grid)) * 20.0 * float(rig.baseline)
        rows, _ = readings(used, rig, points)
        shown = where.imshow(rows.reshape(60, 60), cmap="coolwarm", vmin=-0.7, vmax=0.7, extent=(0, 4, 3, 0))
        where.set_title(title, fontsize=10)
        where.set_axis_off()
        ahead = np.array([[0.0, 0.0, d * float(rig.baseline)] for d in distances])
        axes[2].plot(distances, 100.0 * (1.0 / (1.0 + readings(used, rig, ahead)[1]) - 1.0), label=title)
        print(title, "rows", np.abs(rows).mean().round(3), "px")
    assert shown is not None
    figure.colorbar(shown, ax=axes[:2], label="epipolar error, px")
    axes[2].set(xlabel="distance, baselines", ylabel="error of depth, %", title="what it does to depth")
    axes[2].legend(fontsize=8)
    save(figure, HERE / "yaw-and-centre.png")


def experiments() -> None:
    """The figures of the paper's experiments on the synthetic log; ten minutes, unless it was done before."""
    log, folder = paper.synthetic_log(), HERE.parents[1] / "reproduced" / "for-docs"
    found = paper.reproduce(log, output=folder)
    for path in paper.write_files(found, log, folder):
        if path.suffix == ".png":
            shutil.copy(path, HERE / f"experiments-{path.name}")


def field() -> None:
    """The figures of the field's page, of what is rendered; half an hour on two cores."""
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "field.json"
        words = ["compare", "--preset", "field", "--json", str(target), "--quiet"]
        subprocess.run([sys.executable, "-m", "stereorecal", *words], check=True)
        field_figures(json.loads(target.read_text()))


def field_figures(data: dict) -> None:
    """Draw the figures of the field's page, from the JSON of its table."""
    for name, figure in (("seconds", error_against_seconds), ("coverage", coverage), ("harm", harm)):
        (HERE / f"field-{name}.svg").write_text((figure(data) or "").replace("currentColor", "#666"))


if __name__ == "__main__":
    repair()
    report()
    conventions()
    misfit()
    yaw_and_centre()
    drive()
    motion()
    experiments()
    field()
