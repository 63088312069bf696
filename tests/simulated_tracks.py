"""What a rig that moves sees: tracks of points in pixels of the true rig, for tests of motion."""

import numpy as np
from scipy.spatial.transform import Rotation

import stereorecal as sr
from stereorecal.geometry import rotation_from_vector
from stereorecal.scoring import Tracks

AHEAD, SIDEWAYS, REST = (0.05, 0.0, -1.0), (-1.0, 0.05, 0.0), (0.0, 0.0, 0.0)  # baselines, of points


def tracks_of(
    true: sr.StereoRig,
    move=AHEAD,
    turn=(0.002, -0.004, 0.001),
    seed=0,
    number=600,
    noise=0.1,
    nearness=None,
    with_rig=0.0,
    late=0.0,
) -> Tracks:
    """Tracks of points 5 to 60 baselines away.

    Args:
        move: of points as the left camera has them, baselines.
        turn: a rotation vector [rad].
        noise: pixels of each match.
        nearness: of rays (m, 3): inverse depths in 1 / baselines, in place of random ones.
        with_rig: share of the near half of all points that moves with the rig.
        late: by which the right shutter is, of the time between the pairs.
    """
    rng, edge, baseline = np.random.default_rng(seed), np.array(true.left.size) - 1.0, float(true.baseline)
    left = rng.uniform([0.0, 0.0], edge, (number, 2))
    rays = np.asarray(true.left.rays(left))
    near = rng.uniform(1 / 60, 1 / 5, number) if nearness is None else nearness(rays)
    points = rays / near[:, None] * baseline
    later = points @ np.asarray(rotation_from_vector(np.array(turn)), float).T + baseline * np.array(move)
    stays = (near > np.median(near)) & (rng.random(number) < with_rig)
    later[stays] = points[stays] + 0.02 * baseline * rng.normal(size=3)
    shown = [left, true.left.project(later) + noise * rng.normal(size=left.shape)]
    seen = late_rig(true, move, turn, late)
    partners = [true.right.project(p @ seen.rotation.T + seen.translation) for p in (points, later)]
    partners = [one + noise * rng.normal(size=left.shape) for one in partners]
    partners[1] += shown[1] - true.left.project(later)  # looked for where the corner was seen
    good = np.all([((p >= 0.0) & (p <= edge)).all(axis=1) for p in (*shown, *partners)], axis=0) & (later[:, 2] > 0.1)
    return Tracks(np.stack(shown), np.stack(partners)).of(good)


def late_rig(true: sr.StereoRig, move, turn, late: float) -> sr.StereoRig:
    """The rig as which a late shutter shows one that moves so."""
    rotation = true.rotation @ np.asarray(rotation_from_vector(late * np.array(turn)), float)
    translation = true.translation + true.rotation @ (late * float(true.baseline) * np.array(move))
    return sr.StereoRig.from_rotation(true.left, true.right, rotation, translation)


def rolling_tracks(
    true: sr.StereoRig, readout: float, move=AHEAD, turn=(0.03, -0.02, 0.01), seed=0, number=400, noise=0.1
) -> Tracks:
    """The same through rolling shutters, which read the rows of an image during a share of the time between the pairs
    while the rig drives along an arc (a constant twist); said to be read so."""
    rng, edge, baseline = np.random.default_rng(seed), np.array(true.left.size) - 1.0, float(true.baseline)
    left = rng.uniform([0.0, 0.0], edge, (number, 2))
    points = np.asarray(true.left.rays(left)) / rng.uniform(1 / 60, 1 / 5, number)[:, None] * baseline
    nodes, weights = np.polynomial.legendre.leggauss(4)

    def turned(when):
        return Rotation.from_rotvec(when[:, None] * np.array(turn))

    def shown(camera, began, of_right):
        """In the rows that are read when they show the points."""
        pixels = np.tile(0.5 * edge, (number, 1))
        for _ in range(4):
            when = began + readout * pixels[:, 1] / true.left.size[1]
            seen = turned(when).apply(points)
            for node, weight in zip(nodes, weights, strict=True):
                part = turned(0.5 * (1.0 + node) * when).apply(baseline * np.array(move))
                seen += 0.5 * weight * when[:, None] * part
            pixels = np.asarray(camera.project(seen @ true.rotation.T + true.translation if of_right else seen))
        return pixels

    lefts, rights = ([shown(camera, at, right) for at in (0, 1)] for camera, right in ((true.left, 0), (true.right, 1)))
    rights = [pixels + noise * rng.normal(size=left.shape) for pixels in rights]
    lefts[1] = lefts[1] + noise * rng.normal(size=left.shape)
    good = np.all([((p >= 0.0) & (p <= edge)).all(axis=1) for p in (*lefts, *rights)], axis=0)
    return Tracks(np.stack(lefts), np.stack(rights), readout).of(good)
