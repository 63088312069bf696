"""Rigs with wide lenses: are they repaired, and are calibrations right afterwards? Prints a table for each judge.

    python tests/benchmarks/wide.py [--judges hall,rendered,simulated] [--rigs N] [--first SEED]

hall: the one real fisheye rig at hand, mynteye_fisheye/hall (real_scenes.py), from its stored calibration and from 2.5°
    and 2.25 % of the baseline away. Rows of SIFT matches of the raw images, which no repair sees.
rendered: fisheye rigs of 130 and 190 degrees, whose truth is known, from up to 2.5° and 2.25 % away, prior "exact".
simulated: rigs of 130 and 190 degrees, calibrated with cv2.fisheye on simulated boards, drifted, seen through simulated
    correspondences (`simulated_rigs.py` for the rest): do the stated intervals hold the truth, and what is written?
    Rows of the extrinsics that are written, of what would be if intrinsics were free, and of the best extrinsics that
    there are for such lenses, the truth known. Harmful: as in decisions.py, from 0.02 px on.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace

import coverage
import cv2
import jax
import numpy as np
import scipy.optimize
import simulated_cameras
import simulated_rigs
from accuracy import MOVING, errors
from real_scenes import real, rig_of
from recorded import ROWS_CHANGED, simulated_errors
from sift_rows import sift_matches, sift_rows
from simulated_rigs import AXES
from tables import command_line, show, table_of, words

import stereorecal as sr
from stereorecal.decision import decide
from stereorecal.estimation import as_prior, estimate, rig_parameters

DEGREES, SHARE, STARTS = 2.5, 0.0225, 10
FIELDS = (130.0, 190.0)
EXTRINSICS = sr.Parameters().names
DRIFTS = (("none", 0.0), ("all", 0.1), ("all", 0.5), ("all", 2.5), ("yaw", 0.3), ("pitch", 0.3), ("roll", 0.3))
TERMS = (-0.02, -0.007, 0.002, -0.0012)  # about those of MYNT EYE's lenses


# --- the real one -------------------------------------------------------------------------------------------


def hall(_: argparse.Namespace) -> None:
    """From where it stands, and from some starts."""
    for scene in real(["mynteye_fisheye/hall"]):
        rig, ends = rig_of(scene), []
        matches = sift_matches(rig, scene.pairs)
        table = table_of(
            f"prior | start | verdict | rows before, px | after, px | {' | '.join(AXES)} | depth at 30 B, %",
            title=f"{scene.name}, {len(matches[0])} independent matches",
            left=3,
        )
        for prior in ("default", "exact"):
            for index, start in enumerate([rig, *drifted(rig)]):
                solution = sr.recalibrate(start, scene.pairs, prior=prior)
                before, after = sift_rows(start, matches), sift_rows(solution.rig, matches)
                moved = errors(solution.rig, rig)
                depth = sr.difference(rig, solution.rig).depth_error_percent[30]
                said = f"{'written' if solution.accepted else 'kept'}: {solution.reason.name}"
                name = f"2.5° #{index - 1}" if index else "stored"
                numbers = (f"{before:.3f}", f"{after:.3f}", *(f"{m:+.3f}" for m in moved), f"{depth:+.1f}")
                table.add_row(prior, name, said, *numbers)
                ends += [(prior, after, moved)] if index else []
        show(table)
        for prior in dict.fromkeys(prior for prior, *_ in ends):
            rows, moved = (np.array(some) for some in zip(*(end[1:] for end in ends if end[0] == prior), strict=True))
            apart = ", ".join(f"{a} {m:.3f}" for a, m in zip(AXES, np.ptp(moved, axis=0), strict=True))
            within = f"{(rows <= 0.25).sum()} of {len(rows)} within .25 px, median {np.median(rows):.3f}"
            print(f"{prior}, starts: {within}; ends differ by {apart}")


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


def fisheyes(field: float, draw: np.random.Generator, baseline: float) -> sr.StereoRig:
    """Two of them, side by side but for some tenths of a degree."""
    translation = np.array([-1.0, *draw.normal(0.0, 0.005, 2)])
    extrinsics = [*np.radians(draw.normal(0.0, 0.3, 3)), *(baseline * translation / np.linalg.norm(translation))]
    return sr.StereoRig(fisheye(field, draw), fisheye(field, draw), np.array(extrinsics))


def drifted(rig: sr.StereoRig, first: int = 0) -> Iterator[sr.StereoRig]:
    """Starts."""
    for index in range(STARTS):
        yield sr.synthetic.decalibrate(rig, jax.random.key(first + index), DEGREES, SHARE)


def rendered(_: argparse.Namespace) -> None:
    """Scenes whose truth is known."""
    axes = " | ".join(f"{axis}: median, worst" for axis in AXES)
    heads = f"field | scene | accepted | {axes} | held by the 95 % intervals"
    table = table_of(heads, title="rendered fisheye rigs, prior exact", left=3)
    for field in FIELDS:
        of_field: list[tuple] = []
        for seed, kind in enumerate(MOVING):
            rig = fisheyes(field, np.random.default_rng([seed, int(field)]), 0.36)
            scene, some = sr.synthetic.render(kind, seed, rig=rig), []
            for start in drifted(rig, 100 * seed):
                solution = sr.recalibrate(start, scene.pairs, prior="exact")
                error, known = np.abs(errors(solution.candidate, rig)), solution.uncertainty
                some.append((solution.accepted, error, [] if known is None else error <= np.asarray(known.interval)))
            table.add_row(f"{field:g}°", f"{kind}-{seed}", *cells_of(some))
            of_field += some
        table.add_row(f"{field:g}°", "all", *cells_of(of_field))
    show(table)


def cells_of(found: list[tuple]) -> list[str]:
    """How many are accepted, their errors, and how many of these are held by intervals."""
    taken, off, inside = zip(*found, strict=True)
    errors = [f"{m:.4f}, {w:.4f}" for m, w in zip(np.median(off, axis=0), np.max(off, axis=0), strict=True)]
    return [f"{sum(taken)} of {len(taken)}", *errors, f"{100 * np.mean(np.concatenate(inside)):.0f} %"]


# --- simulated calibrations -----------------------------------------------------------------------------------


def simulated(options: argparse.Namespace) -> None:
    """Calibrated with cv2.fisheye on simulated boards, drifted, seen through simulated correspondences."""
    heads = "field | drift | rigs | written | harmful | depth held, 10 30 B | pitch yaw roll y z held"
    heads += " | rows 30 B before, px | mean's | used | with lenses | best extrinsics'"
    heads += " | |depth| 30 B before, % | used | with lenses"
    table = table_of(heads, title="simulated calibrations of fisheye rigs", left=2)
    for field in FIELDS:
        seeds = range(options.first, options.first + 2 * options.rigs, 2)
        of_field = [[judged(one) for one in of_seed(seed, field)] for seed in seeds]
        for (kind, degrees), some in zip(DRIFTS, zip(*of_field, strict=True), strict=True):
            table.add_row(f"{field:g}°", f"{kind} {degrees:g}°" if degrees else kind, *line(list(some)))
        table.add_row(f"{field:g}°", "every", *line([one for some in of_field for one in some]))
    show(table)


def line(some: list[dict]) -> list[str]:
    """A line of the table, of some rigs."""
    of = {name: np.array([one[name] for one in some], float) for name in some[0]}
    worst = np.nanquantile(of["rows used"], 0.95)
    return [
        f"{len(some)}",
        f"{100 * of['written'].mean():.0f} %",
        f"{of['harmful'].sum():.0f}",
        " ".join(f"{100 * share:.0f}" for share in of["depth held"].mean(0)),
        " ".join(f"{100 * share:.0f}" for share in of["axes held"].mean(0)),
        f"{np.nanmedian(of['rows before']):.3f}",
        f"{np.nanmedian(of['rows mean']):.3f}",
        f"{np.nanmedian(of['rows used']):.3f}, 95 %: {worst:.3f}",
        *(f"{np.nanmedian(of[f'rows {name}']):.3f}" for name in ("lenses", "best")),
        *(f"{np.nanmedian(np.abs(of[f'depth {name}'])):.2f}" for name in ("before", "used", "lenses")),
    ]


def of_seed(seed: int, field: float) -> Iterator[simulated_rigs.Simulated]:
    """The rig of a seed after each kind of drift."""
    true, given = calibrated(seed, field)
    eyes = [simulated_cameras.Eye(camera, None, np.eye(3), np.eye(3)) for camera in (true.left, true.right)]
    for index, (kind, degrees) in enumerate(DRIFTS):
        drift = simulated_rigs.drift_of(kind, degrees, float(true.baseline), np.random.default_rng([seed, 3, index]))
        moved = true.with_extrinsics(true.extrinsics + drift)
        yield simulated_rigs.Simulated(seed, given, *eyes, moved.rotation, moved.translation, moved, False)


def richer(field: float, draw: np.random.Generator, size: tuple[int, int] = (640, 480)) -> sr.Camera:
    """A lens of such a field that `cv2.fisheye` only approximates: a double sphere."""
    terms, half = np.array([draw.uniform(-0.25, -0.1), draw.uniform(0.52, 0.6)]), np.radians(0.5 * field)
    edge = sr.Camera(size, np.diag([100.0, 100.0, 1.0]), terms, model="ds").project(
        np.array([[np.sin(half), 0.0, np.cos(half)]])
    )[0, 0]
    like = fisheye(field, draw, size)
    matrix = np.array(like.matrix)
    matrix[(0, 1), (0, 1)] = 0.5 * size[0] / edge * 100.0 * matrix[(0, 1), (0, 1)] / matrix[0, 0]
    return sr.Camera(size, matrix, terms, model="ds")


def calibrated(seed: int, field: float) -> tuple[sr.StereoRig, sr.StereoRig]:
    """A true rig, and what cv2.fisheye makes of 6 to 30 views of a board at 1.2 to 12 baselines, whose squares may be
    off by 0.2 %; a quarter of the lenses is not quite as cv2.fisheye has it, and of a tenth something was held that
    should be free, as in `simulated_rigs.py`. Another draw where that fails."""
    for attempt in range(100):
        draw = np.random.default_rng([seed, int(field), attempt])
        true = fisheyes(field, draw, float(np.exp(draw.uniform(np.log(0.06), np.log(0.5)))))
        if draw.random() < 0.25:
            true = replace(true, left=richer(field, draw), right=richer(field, draw))
        views, noise = seen_boards(true, draw, int(draw.integers(6, 31))), float(np.exp(draw.uniform(-3.0, -1.2)))
        corners = [np.stack(some) for some in zip(*views, strict=True)]
        seen = [some + draw.normal(0.0, noise, some.shape) for some in corners[1:]]
        squares = 1.0 + draw.choice([0.0, 0.0, -0.002, 0.002])
        objects = [squares * one[None] for one in corners[0]]
        flags = cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
        if draw.random() < 0.1:
            flags |= int(draw.choice([cv2.CALIB_FIX_K3 | cv2.CALIB_FIX_K4, cv2.CALIB_FIX_PRINCIPAL_POINT]))
        until = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
        size, monos = true.left.size, []
        try:
            for side, some in enumerate(seen):
                focal = 0.95 * float((true.left, true.right)[side].focal[0])
                guess = np.array([[focal, 0, 319.5], [0, focal, 239.5], [0, 0, 1]])
                options = {"flags": flags | cv2.CALIB_USE_INTRINSIC_GUESS, "criteria": until}
                pixels = [one[None] for one in some]
                monos.append(cv2.fisheye.calibrate(objects, pixels, size, guess, np.zeros((4, 1)), **options)[:3])
            (_, K1, D1), (_, K2, D2) = monos
            both = [[one[None] for one in some] for some in seen]
            rms, K1, D1, K2, D2, R, T, *_ = cv2.fisheye.stereoCalibrate(
                objects, *both, K1, D1, K2, D2, size, flags=cv2.CALIB_FIX_INTRINSIC, criteria=until
            )
            given = sr.StereoRig.from_matrices(K1, D1, K2, D2, R, T, size, model="equidistant")
        except (cv2.error, sr.InputError):
            continue
        if max(rms, monos[0][0], monos[1][0]) < 1.0:
            return true, given
    raise RuntimeError(f"no calibration of seed {seed} succeeds")


def seen_boards(rig: sr.StereoRig, draw: np.random.Generator, number: int) -> list[tuple[np.ndarray, ...]]:
    """Views of a board of 9 x 6 corners, turned to the camera wherever it is, up to 65 degrees off the axis: corners on
    the board, and in both images."""
    far = float(np.exp(draw.uniform(0.0, np.log(4.0))))
    square = 0.16 * far * float(rig.baseline)
    grid = np.mgrid[0:9, 0:6].reshape(2, -1).T - [4.0, 2.5]
    board, views = np.column_stack([grid, np.zeros(len(grid))]) * square, []
    while len(views) < number:
        off, around = np.radians(draw.uniform(0.0, 65.0)), draw.uniform(0.0, 2.0 * np.pi)
        towards = np.array([np.sin(off) * np.cos(around), np.sin(off) * np.sin(around), np.cos(off)])
        turn = cv2.Rodrigues(np.radians(draw.uniform(-30.0, 30.0, 3)))[0]
        aside = cv2.Rodrigues(off * np.array([-np.sin(around), np.cos(around), 0.0]))[0]
        points = board @ (aside @ turn).T + towards * far * float(rig.baseline) * draw.uniform(1.2, 3.0)
        right = points @ rig.rotation.T + rig.translation
        pixels = [np.asarray(camera.project(some)) for camera, some in ((rig.left, points), (rig.right, right))]
        ahead = min(float((some[:, 2] / np.linalg.norm(some, axis=1)).min()) for some in (points, right))
        if ahead > np.cos(np.radians(80.0)) and all(simulated_cameras.inside(p, rig.left.size).all() for p in pixels):
            views.append((board, *pixels))
    return views


def judged(rig: simulated_rigs.Simulated) -> dict[str, np.ndarray | float]:
    """What an estimate says of a rig, and what would be written, against the truth; and what the extrinsics that lose
    least would be worth if all else were known."""
    chart = rig_parameters(rig.calibrated)
    view = sr.view(rig.calibrated)
    seen = estimate(rig.correspondences(1), rig.calibrated, as_prior(None, chart), view=view)
    decision = decide(seen, EXTRINSICS)
    held = coverage.measured(rig, seen)
    written = not decision.refused
    used = seen.chart.rig_at(decision.theta) if written else rig.calibrated
    freed = decide(seen, [name for name in seen.names if name != "baseline"])
    with_lenses = seen.chart.rig_at(freed.theta) if not freed.refused else rig.calibrated
    before, after = (simulated_errors(rig, one) for one in (rig.calibrated, used))
    at = np.array([30.0])
    of = {"before": rig.calibrated, "used": used, "lenses": with_lenses, "best": best_extrinsics(rig)}
    rows, depth = (
        {name: float(f(one, at)[0]) for name, one in of.items()} for f in (rig.rows_px, rig.depth_error_percent)
    )
    return {
        "written": written,
        "harmful": after.worse_than(before, ROWS_CHANGED),
        "depth held": held["depth"][1:3],
        "axes held": held["axes"],
        "rows mean": held["rows"][2],
        **{f"rows {name}": value for name, value in rows.items()},
        **{f"depth {name}": value for name, value in depth.items()},
    }


def best_extrinsics(rig: simulated_rigs.Simulated) -> sr.StereoRig:
    """The calibration with the extrinsics under which rows at the judged distances are aligned best, by the truth."""
    chart, at = rig_parameters(rig.calibrated), np.zeros(rig_parameters(rig.calibrated).dim)
    free = slice(len(EXTRINSICS))

    def moved(z: np.ndarray) -> sr.StereoRig:
        at[free] = z
        return chart.rig_at(at)

    def rows(z: np.ndarray) -> np.ndarray:
        return np.nan_to_num(np.concatenate([one for one, _, _ in rig.readings(moved(z), (5.0, 10.0, 30.0))]))

    true = rig.calibrated.with_extrinsics(rig.true_raw.extrinsics)
    return moved(scipy.optimize.least_squares(rows, chart.coordinates_of(true)[free], loss="soft_l1").x)


JUDGES = {"hall": hall, "rendered": rendered, "simulated": simulated}


def main() -> None:
    """Ask the judges."""
    parser = command_line(__doc__)
    parser.add_argument("--judges", default=",".join(JUDGES), help="comma separated")
    parser.add_argument("--rigs", type=int, default=40, help="simulated, of each field")
    parser.add_argument("--first", type=int, default=0, help="seed of the first of them; odd ones stay unseen")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    for judge in words(options.judges):
        JUDGES[judge](options)


if __name__ == "__main__":
    main()
