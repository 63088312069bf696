"""Range measurements of a rendered scene, as of a LIDAR."""

import numpy as np
from jaxtyping import Float

from stereorecal.geometry import StereoRig
from stereorecal.synthetic._default_rig import default_rig
from stereorecal.synthetic.rendering._camera_rays import world_rays
from stereorecal.synthetic.scenes import make_world
from stereorecal.synthetic.world._raycast import depth

_TRIES = 20  # pixels for each that is wanted
_BORDER = 0.05  # of the image that is left out
_NEAREST, _FARTHEST = 5.0, 40.0  # baselines


def ranges(
    kind: str,
    seed: int,
    *,
    rig: StereoRig | None = None,
    number: int = 10,
    noise: float = 0.01,
    draw: int = 0,
) -> tuple[Float[np.ndarray, "n 2"], Float[np.ndarray, "n"]]:
    """Pixels (column, row) of the left image, and the distance [m] of what they show from the left camera.

    Args:
        kind, seed, rig: as `ground_truth` has them, of the first frame.
        number: how many; fewer where the scene shows too few things so far away.
        noise: standard deviation, as a share of the distance.
        draw: other pixels and noise.
    """
    rig, world = rig or default_rig(), make_world(kind, seed)
    random = np.random.default_rng([seed, 0, draw, 11])
    size = np.array(rig.left.size, float)
    pixels = random.uniform(_BORDER * size, (1 - _BORDER) * size, (_TRIES * number, 2)).round()
    directions = np.asarray(rig.left.rays(pixels))[None]
    depths = depth(world, world_rays(world.motion.pose(0), rig, 0, directions.astype(np.float32), 600.0))[0]
    metres = np.linalg.norm(directions[0], axis=-1) * depths
    baseline = float(rig.baseline)
    within = np.flatnonzero((metres > _NEAREST * baseline) & (metres < _FARTHEST * baseline))[:number]
    return pixels[within], metres[within] * (1.0 + noise * random.normal(size=within.size))
