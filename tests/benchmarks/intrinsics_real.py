"""Real scenes for `intrinsics.py`: what the intrinsics of some recordings say of the rows of others, whether the
intervals of single recordings reach the end point of all, and what freeing good intrinsics costs."""

import os
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import stereorecal as sr
from stereorecal.geometry import with_unit_baseline
from stereorecal.scoring import host, median_row_error, pyramid
from stereorecal.scoring.host import with_measured_range

AXES = ("pitch", "yaw", "roll", "y", "z")
BOTH = ("extrinsics", "intrinsics")
BUMBLEBEE = ("garden01", "stones01", "sundial01", "chair01")
SEQUENCES = ("euroc/vicon_room_seq", "kitti_odometry/suburb_seq")
GOOD = ("euroc/vicon_room_seq", "middlebury2014/motorcycle_quarter")


def loaded(name: str) -> sr.Scene:
    """A scene of the folder STEREORECAL_DATA, all its frames."""
    return sr.io.load_scene(Path(os.environ["STEREORECAL_DATA"]) / name)


def bumblebee() -> list[sr.Scene]:
    """The four scenes of one camera."""
    return [loaded(f"boofcv_bumblebee2/{name}") for name in BUMBLEBEE]


def frames_of(scene: sr.Scene) -> list[sr.Scene]:
    """Each frame as a recording of its own."""
    return [replace(scene, name=pair.name, pairs=(pair,)) for pair in scene.pairs]


def end(rig: sr.StereoRig) -> np.ndarray:
    """Pitch, yaw, roll in degrees, y, z in percent of the baseline."""
    extrinsics = np.asarray(rig.extrinsics)
    return np.array([*np.degrees(extrinsics[:3]), *(100 * extrinsics[4:] / abs(extrinsics[3]))])


def solved(found: sr.Solution | None) -> sr.Solution:
    """The solution that must be there."""
    assert found is not None
    return found


def rig_of(scene: sr.Scene) -> sr.StereoRig:
    """The rig that must be there."""
    assert scene.rig is not None
    return scene.rig


def singles() -> None:
    """Do the 95 % intervals of single recordings, intrinsics as given, reach where all of them together end?"""
    table = Table("rig", "recordings", "covered %", "scatter", "half width", "half width / scatter", box=None)
    hits, ratios = [], []
    rigs = {"bumblebee2": bumblebee()} | {name: frames_of(loaded(name)) for name in SEQUENCES}
    for name, recordings in rigs.items():
        pairs = [pair for recording in recordings for pair in recording.pairs]
        common = end(sr.recalibrate(rig_of(recordings[0]), pairs).candidate)
        found = [sr.recalibrate(rig_of(one), one.pairs) for one in recordings]
        ends = np.array([end(one.candidate) for one in found])
        half = np.array([one.uncertainty.interval for one in found if one.uncertainty is not None])
        covered, scatter = np.abs(ends - common) <= half, ends.std(axis=0, ddof=1)
        hits.append(covered)
        ratios.append(half / scatter)
        middle = np.median(half, axis=0)
        cells = (covered.mean(axis=0) * 100, scatter, middle, middle / scatter)
        digits = (0, 4, 4, 1)
        table.add_row(name, str(len(found)), *(_five(c, d) for c, d in zip(cells, digits, strict=True)))
    Console(width=160).print(table)
    pooled = np.concatenate(hits)
    print(
        f"intervals of single recordings ({', '.join(AXES)}), all {pooled.size} pooled: "
        f"cover {100 * pooled.mean():.0f} %; half width {np.median(np.concatenate(ratios)):.1f} x the scatter (median)"
    )


def _five(values: np.ndarray, digits: int) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)


def suburb() -> None:
    """The scatter of single frames of a drive that share intrinsics."""
    recordings = frames_of(loaded("kitti_odometry/suburb_seq"))
    alone = [solved(repair.solution) for repair in sr.recalibrate_many(recordings)]
    joint = [solved(repair.solution) for repair in sr.recalibrate_many(recordings, free=BOTH)]
    seen = joint[0].intrinsics
    assert seen is not None
    for name, found in (("given", alone), (f"joint ({seen.outcome.name})", joint)):
        ends = np.array([end(one.candidate) for one in found])
        print(f"suburb_seq, scatter of {', '.join(AXES)}, intrinsics {name}:", ends.std(axis=0, ddof=1).round(4))


def good() -> None:
    """Freed where they are good already: taken or not, and how far the rig then lies from the stored one."""
    for name in GOOD:
        scene = loaded(name)
        fixed, freed = (sr.recalibrate(rig_of(scene), scene.pairs, free=free) for free in (None, BOTH))
        assert freed.intrinsics is not None
        assert fixed.uncertainty is not None
        off = [np.abs(end(one.candidate) - end(rig_of(scene))) for one in (fixed, freed)]
        worse = np.any(off[1] > off[0] + fixed.uncertainty.interval)
        print(
            f"{name}: {freed.intrinsics.outcome.name}; off the stored rig: fixed {off[0].round(4)}, "
            f"freed {off[1].round(4)}; worse by more than the interval: {bool(worse)}"
        )


def shared(recordings: Sequence[sr.Scene]) -> sr.Solution:
    """A solution with the intrinsics that recordings share: of the first one that takes them, if one does."""
    found = [solved(repair.solution) for repair in sr.recalibrate_many(recordings, free=BOTH)]
    return next((one for one in found if one.intrinsics is not None and one.intrinsics.taken), found[0])


def bumblebee2() -> None:
    """Intrinsics from some scenes of the camera, rows and end points of the others."""
    given = bumblebee()
    table = Table("intrinsics from", "rows of", "given px", "refined px", "intrinsics", box=None)
    before, after = [], []
    for chosen in combinations(range(4), 2):
        found = shared([given[i] for i in chosen])
        assert found.intrinsics is not None
        for other in sorted(set(range(4)) - set(chosen)):
            scene = given[other]
            ends = [sr.recalibrate(rig, scene.pairs).candidate for rig in (rig_of(scene), with_lenses(scene, found))]
            medians = [seen(rig, scene.pairs) for rig in ends]
            before.append(medians[0])
            after.append(medians[1])
            names = " ".join(BUMBLEBEE[i] for i in chosen)
            table.add_row(names, scene.name, *(f"{m:.3f}" for m in medians), found.intrinsics.outcome.name)
    Console(width=120).print(table)
    print(f"rows of the others: given median {np.median(before):.3f}, worst {max(before):.3f} px")
    print(f"rows of the others: refined median {np.median(after):.3f}, worst {max(after):.3f} px")
    rest = []
    for left_out, scene in enumerate(given):
        others = [given[i] for i in range(4) if i != left_out]
        found = shared(others)
        rigs = (rig_of(scene), with_lenses(scene, found))
        rest.append([end(sr.recalibrate(rig, scene.pairs).candidate) for rig in rigs])
    for name, scatter in zip(("given", "refined"), np.std(np.array(rest), axis=0, ddof=1), strict=True):
        print(f"bumblebee2, scatter of {', '.join(AXES)}, intrinsics {name}:", scatter.round(4))


def with_lenses(scene: sr.Scene, found: sr.Solution) -> sr.StereoRig:
    """The scene's rig with the intrinsics of a solution."""
    return replace(rig_of(scene), left=found.candidate.left, right=found.candidate.right)


def seen(rig: sr.StereoRig, pairs: Sequence[sr.Pair]) -> float:
    """Median |row difference| of the correspondences under a rig."""
    images = pyramid(rig, pairs)
    extrinsics = with_unit_baseline(rig.extrinsics)
    return median_row_error(
        host.correspondences(images.at(1.0), extrinsics, with_measured_range(None, images)), extrinsics
    )


PARTS = {"singles": singles, "suburb": suburb, "good": good, "bumblebee2": bumblebee2}
