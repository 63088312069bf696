"""Rigs with wide lenses: are they repaired, and are calibrations right afterwards? Prints a table for each judge.

    python tests/benchmarks/wide.py [--judges hall,rendered,simulated] [--starts N] [--rigs N] [--first SEED]

hall: the one real fisheye rig at hand, data/mynteye_fisheye/hall (in STEREORECAL_DATA), from its stored calibration and
    from 2.5° and 2.25 % of the baseline away. Rows of SIFT matches of the raw images, which no repair sees, within the
    rig's pinhole view; and of all matches, wherever they lie, the angle between a ray and the epipolar plane of its
    partner, in pixels of the middle of the image.
rendered: fisheye rigs of 130 and 190 degrees, whose truth is known, from up to 2.5° and 2.25 % away, prior "exact".
simulated: rigs of 130 and 190 degrees, calibrated with cv2.fisheye on simulated boards, drifted, seen through simulated
    correspondences (`simulated_rigs.py` for the rest): do the stated intervals hold the truth, and what is written?
    Harmful: accepted, and rows at 30 baselines are worse by more than 0.02 px, or depth there by more than 1 %.
"""

import argparse
import os
from collections.abc import Iterator
from pathlib import Path

import cv2
import jax
import numpy as np
from accuracy import AXES, errors
from rich.console import Console
from rich.table import Table
from stereorecal_features._matches import matched_pixels

import stereorecal as sr
from stereorecal.geometry import rectifying_rotations

CHECKOUT = Path(__file__).resolve().parents[2]
DATA = Path(os.environ.get("STEREORECAL_DATA", CHECKOUT / "../shared/data"))
DEGREES, SHARE = 2.5, 0.0225
FIELDS = (130.0, 190.0)
KINDS = ("harbour", "coast", "street")
TERMS = (-0.02, -0.007, 0.002, -0.0012)  # about those of MYNT EYE's lenses


# --- the real one -------------------------------------------------------------------------------------------


def independent(scene: sr.Scene) -> tuple[np.ndarray, np.ndarray]:
    """Pixels (n, 2) of SIFT features that are each other's best match, without any calibration's say: outliers are told
    by an essential matrix of their own, two pixels off its planes."""
    assert scene.rig is not None
    found, cameras = [], (scene.rig.left, scene.rig.right)
    for pair in scene.pairs:
        left, right = matched_pixels(pair, 8000, 0.02, 0.8)
        flat = [np.asarray(camera.rays(pixels))[:, :2] for camera, pixels in zip(cameras, (left, right), strict=True)]
        good = np.all([np.linalg.norm(points, axis=1) < 4.0 for points in flat], axis=0)
        threshold = 2.0 / float(scene.rig.left.focal[0])
        _, inliers = cv2.findEssentialMat(
            *(points[good] for points in flat), np.eye(3), method=cv2.USAC_MAGSAC, prob=0.9999, threshold=threshold
        )
        found.append([pixels[good][inliers.ravel() > 0] for pixels in (left, right)])
    left, right = (np.concatenate(side) for side in zip(*found, strict=True))
    return left, right


def rows_of(rig: sr.StereoRig, pixels: tuple[np.ndarray, np.ndarray], view: sr.View) -> tuple[float, float]:
    """Of matched pixels: median |row difference| [px] of those within a view, and the median angle off the epipolar
    plane [px of the middle] of all."""
    rays = [np.asarray(c.directions(p)) for c, p in zip((rig.left, rig.right), pixels, strict=True)]
    turned = [ray @ turn.T for ray, turn in zip(rays, rectifying_rotations(rig.rotation, rig.translation), strict=True)]
    (column, row), (_, other) = (view.pixels(ray, side) for side, ray in enumerate(turned))
    width, height = view.size
    shown = (column >= 0) & (column <= width - 1) & (row >= 0) & (row <= height - 1)
    angles = np.subtract(*(np.arctan2(ray[:, 1], ray[:, 2]) for ray in turned))
    along = np.hypot(turned[0][:, 1], turned[0][:, 2]) / np.linalg.norm(turned[0], axis=1)
    return float(np.median(np.abs(row - other)[shown])), float(view.focal * np.median(np.abs(angles) * along))


def hall(options: argparse.Namespace) -> None:
    """From where it stands, and from some starts."""
    folder = DATA / "mynteye_fisheye/hall"
    if not folder.exists():
        print(f"skipped: {folder} is not there")
        return
    scene = sr.io.load_scene(folder)
    assert scene.rig is not None
    pixels, view = independent(scene), sr.view(scene.rig)
    table = table_of(
        f"mynteye_fisheye/hall, {len(pixels[0])} independent matches",
        ("start", "prior", "verdict", "rows before, px", "after, px", "everywhere before, px", "after, px"),
        (*(f"{axis}" for axis in AXES), "depth at 30 B, %"),
    )
    ends = []
    for prior in ("default", "exact"):
        for index, start in enumerate([scene.rig, *drifted(scene.rig, options.starts)]):
            solution = sr.recalibrate(start, scene.pairs, prior=prior)
            before, after = rows_of(start, pixels, view), rows_of(solution.rig, pixels, view)
            numbers = (before[0], after[0], before[1], after[1])
            moved = errors(solution.rig, scene.rig)
            depth = sr.difference(scene.rig, solution.rig).depth_error_percent[30]
            name = f"2.5° #{index - 1}" if index else "stored"
            said = f"{'written' if solution.accepted else 'kept'}: {solution.reason.name}"
            table.add_row(
                name, prior, said, *(f"{n:.3f}" for n in numbers), *(f"{m:+.3f}" for m in moved), f"{depth:+.1f}"
            )
            ends.append((prior, index, moved))
    show(table)
    for prior in ("default", "exact"):
        some = np.array([moved for of, index, moved in ends if of == prior and index])
        if len(some):
            spread = np.ptp(some, axis=0)
            print(f"{prior}: ends of {len(some)} starts differ by {dict(zip(AXES, spread.round(4), strict=True))}")


# --- rendered ones ------------------------------------------------------------------------------------------


def fisheye(field: float, draw: np.random.Generator, size: tuple[int, int] = (640, 480)) -> sr.Camera:
    """An equidistant lens whose image is so wide; no two are the same."""
    half = np.radians(0.5 * field)
    terms = np.array(TERMS) * draw.uniform(0.8, 1.2)
    grown = half * (1.0 + np.polyval([*terms[::-1], 0.0], half * half))
    focal = 0.5 * size[0] / grown * (1.0 + draw.normal(0.0, 0.003))
    centre = (np.array(size) - 1.0) / 2.0 + draw.normal(0.0, 0.01 * size[0], 2)
    matrix = np.array([[focal, 0, centre[0]], [0, focal * (1.0 + draw.normal(0.0, 3e-4)), centre[1]], [0, 0, 1.0]])
    return sr.Camera(size, matrix, terms, model="equidistant")


def rig_of(field: float, draw: np.random.Generator, baseline: float) -> sr.StereoRig:
    """Two of them, side by side but for some tenths of a degree."""
    translation = np.array([-1.0, *draw.normal(0.0, 0.005, 2)])
    extrinsics = [*np.radians(draw.normal(0.0, 0.3, 3)), *(baseline * translation / np.linalg.norm(translation))]
    return sr.StereoRig(fisheye(field, draw), fisheye(field, draw), np.array(extrinsics))


def drifted(rig: sr.StereoRig, number: int, first: int = 0) -> Iterator[sr.StereoRig]:
    """Starts."""
    for index in range(number):
        yield sr.synthetic.decalibrate(rig, jax.random.key(first + index), DEGREES, SHARE)


def rendered(options: argparse.Namespace) -> None:
    """Scenes whose truth is known."""
    table = table_of(
        "rendered fisheye rigs, prior exact",
        ("field", "scene", "accepted"),
        (*(f"{axis}: median, worst" for axis in AXES), "held by the 95 % intervals"),
    )
    for field in FIELDS:
        of_field, accepted, held = [], [], []
        for seed, kind in enumerate(KINDS):
            rig = rig_of(field, np.random.default_rng([seed, int(field)]), 0.36)
            scene = sr.synthetic.render(kind, seed, rig=rig)
            some, taken, inside = [], [], []
            for start in drifted(rig, options.starts, 100 * seed):
                solution = sr.recalibrate(start, scene.pairs, prior="exact")
                taken.append(solution.accepted)
                error = np.abs(errors(solution.candidate, rig))
                some.append(error)
                if solution.uncertainty is not None:
                    inside.append(error <= np.asarray(solution.uncertainty.interval))
            table.add_row(f"{field:g}°", f"{kind}-{seed}", shares(taken), *middles(some), held_by(inside))
            of_field, accepted, held = of_field + some, accepted + taken, held + inside
        table.add_row(f"{field:g}°", "all", shares(accepted), *middles(of_field), held_by(held))
    show(table)


def shares(taken: list[bool]) -> str:
    return f"{sum(taken)} of {len(taken)}"


def middles(found: list[np.ndarray]) -> list[str]:
    return [f"{m:.4f}, {w:.4f}" for m, w in zip(np.median(found, axis=0), np.max(found, axis=0), strict=True)]


def held_by(inside: list[np.ndarray]) -> str:
    return f"{100 * np.mean(inside):.0f} %" if inside else "-"


# --- printing -----------------------------------------------------------------------------------------------


def table_of(title: str, left: tuple[str, ...], right: tuple[str, ...]) -> Table:
    table = Table(title=title, title_justify="left", box=None)
    for head in left:
        table.add_column(head)
    for head in right:
        table.add_column(head, justify="right")
    return table


def show(table: Table) -> None:
    Console(width=200).print(table)


JUDGES = {"hall": hall, "rendered": rendered}


def main() -> None:
    """Ask the judges."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--judges", default=",".join(JUDGES), help="comma separated")
    parser.add_argument("--starts", type=int, default=10, help="2.5° off, for each scene")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    for judge in options.judges.split(","):
        JUDGES[judge](options)


if __name__ == "__main__":
    main()
