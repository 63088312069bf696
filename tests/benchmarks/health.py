"""Does one look tell a good calibration from a bad one? Prints a table of verdicts.

    python tests/benchmarks/health.py [--only NAME,…] [--draws N]

Rendered scenes under their true rig, real ones (real_scenes.py) under the median candidate of three repairs from 0.3°
away: as they are; with pitch or roll off by 0.05° or yaw by 0.3°, either way; with a rotation off by 1 to 2.5° and the
baseline by up to 2 %. The time of a look is told in counts: matches of the same frames at full size.
"""

import time
from collections.abc import Iterator

import numpy as np
from accuracy import MOVING, REAL, consensus
from real_scenes import real, rig_of
from tables import among, command_line, show, table_of, words

import stereorecal as sr
from stereorecal.scoring import pyramid
from stereorecal.scoring.host import with_measured_range

RENDERED = [(kind, seed) for kind in MOVING for seed in (1, 2, 3)]
APART = "ukulele_wall"  # with little texture
SMALL = {"pitch 0.05°": (0, 0.05), "yaw 0.3°": (1, 0.3), "roll 0.05°": (2, 0.05)}


def scenes(wanted: list[str]) -> Iterator[sr.Scene]:
    for kind, seed in RENDERED:
        if among(f"{kind}-{seed}", wanted):
            yield sr.synthetic.render(kind, seed)
    yield from map(consensus, real([name for name in REAL if among(name, wanted)]))


def states(rig: sr.StereoRig, draws: int) -> Iterator[tuple[str, sr.StereoRig]]:
    """The rig, and the same off by known amounts."""
    yield "reference", rig
    for case, (axis, degrees) in SMALL.items():
        for sign in (1, -1):
            yield case, rig.with_extrinsics(rig.extrinsics + sign * np.radians(degrees) * np.eye(6)[axis])
    draw = np.random.default_rng(17)
    for _ in range(draws):
        angles = draw.uniform(-1, 1, 3)
        angles *= draw.uniform(1.0, 2.5) / np.abs(angles).max()
        shifts = draw.uniform(-0.02, 0.02, 2) * rig.baseline
        yield "1 to 2.5°", rig.with_extrinsics(rig.extrinsics + np.array([*np.radians(angles), 0.0, *shifts]))


def looked(scene: sr.Scene, case: str, rig: sr.StereoRig) -> tuple[str, float]:
    """The condition, and what the look took in counts: with the disparity range given, as the target of the cost is
    stated."""
    matcher = with_measured_range(None, pyramid(rig, scene.pairs))
    took = []
    for function in (sr.score, sr.health):
        began = time.perf_counter()
        found = function(rig, scene.pairs, matcher=matcher)
        took.append(time.perf_counter() - began)
    print(scene.name, "|", case, "|", found.verdict, "|", f"{took[1] / took[0]:.1f}", flush=True)
    return found.condition.name, took[1] / took[0]


def main() -> None:
    """Look, judge, print."""
    parser = command_line(__doc__)
    parser.add_argument("--only", default="", help="parts of names of scenes, comma separated")
    parser.add_argument("--draws", type=int, default=6, help="rigs far off, of each scene")
    options = parser.parse_args()
    looks: dict[str, list[tuple[str, float]]] = {}
    for scene in scenes(words(options.only)):
        for case, rig in states(rig_of(scene), options.draws):
            looks.setdefault(f"{APART}: {case}" if APART in scene.name else case, []).append(looked(scene, case, rig))
    table = table_of("case | looks | healthy | repair | cannot tell | counts (median)")
    for case, found in looks.items():
        conditions, counts = zip(*found, strict=True)
        shares = [f"{conditions.count(name) / len(found):.0%}" for name in ("HEALTHY", "REPAIR", "CANNOT_TELL")]
        table.add_row(case, f"{len(found)}", *shares, f"{np.median(counts):.1f}")
    show(table)


if __name__ == "__main__":
    main()
