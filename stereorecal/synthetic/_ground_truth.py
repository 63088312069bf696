"""Ground truth of a rendered pair: disparity and occlusions, and ranges as a LIDAR measures them."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.geometry import Camera, StereoRig, View, rectifying_rotations, view as make_view
from stereorecal.synthetic._render import default_rig, pixel_grid, world_rays
from stereorecal.synthetic._scenes import make_world
from stereorecal.synthetic._world import depth

_TRIES = 20  # pixels for each that is wanted
_BORDER = 0.05  # of the image that is left out
_NEAREST, _FARTHEST = 5.0, 40.0  # baselines


@dataclass(frozen=True, eq=False)
class GroundTruth:
    """Ground truth of the rectified left image.

    Attributes:
        disparity: (h, w) float32 in pixels, for every pixel; the sky has the disparity of a point at infinity.
        occluded: (h, w) bool, True where the point is hidden from the right camera or outside its image.
    """

    disparity: Float[np.ndarray, "h w"]
    occluded: Bool[np.ndarray, "h w"]


def ground_truth(
    kind: str, seed: int, *, rig: StereoRig | None = None, view: View | None = None, frame: int = 0
) -> GroundTruth:
    """Ground truth of the pair with index `frame` of `render(kind, seed, rig=rig, frames=frame + 1)`.

    Args:
        view: the rectified cameras (default: the rig's own view).

    Raises:
        InputError: for an unknown kind or a negative seed.
    """
    rig, world = rig or default_rig(), make_world(kind, seed)
    view = view or make_view(rig)
    left_turn, _ = rectifying_rotations(rig.rotation, rig.translation)
    columns, rows = np.moveaxis(pixel_grid(view.size), -1, 0)
    rectified = np.asarray(view.directions(columns, rows, 0))
    directions = rectified @ left_turn
    pose, spread = world.motion(frame), 0.5 / float(view.focal)
    rays = world_rays(pose, rig, 0, directions.astype(np.float32), spread)
    distance = depth(world, rays)  # in lengths of the directions
    nearness = float(rig.baseline) / distance.astype(float)
    in_right = rectified - nearness[..., None] * [1.0, 0.0, 0.0]
    disparity = np.asarray(view.pixels(rectified, 0)[0] - view.pixels(in_right, 1)[0])

    # Occlusion: cast the ray from the right camera to each point. The sky, put at 1e5 m, is hidden by what stands
    # before it as well; half a percent of the depth is tolerated for rounding.
    points = directions * np.where(np.isfinite(distance), distance, 1e5)[..., None]
    in_right = points @ rig.rotation.T + rig.translation
    away = np.linalg.norm(in_right, axis=-1)
    back = in_right / away[..., None]
    second = world_rays(pose, rig, 1, back.astype(np.float32), spread)
    hidden = (depth(world, second) < 0.995 * away) | ~np.broadcast_to(view.shows(columns, rows, 0), away.shape)
    return GroundTruth(disparity.astype(np.float32), hidden | ~_inside(rig.right, back))


def _inside(camera: Camera, directions: Float[np.ndarray, "h w 3"]) -> Bool[np.ndarray, "h w"]:
    """Mask of the unit vectors, camera frame, that project into the image."""
    within = directions[..., 2] > np.cos(float(camera.lens_field))
    pixels = camera.project(np.where(within[..., None], directions, [0.0, 0.0, 1.0]))
    limit = np.array(camera.size) - 1.0
    return within & np.all((pixels >= 0.0) & (pixels <= limit), axis=-1)


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
    depths = depth(world, world_rays(world.motion(0), rig, 0, directions.astype(np.float32), 0.5 / 600.0))[0]
    metres = np.linalg.norm(directions[0], axis=-1) * depths
    baseline = float(rig.baseline)
    within = np.flatnonzero((metres > _NEAREST * baseline) & (metres < _FARTHEST * baseline))[:number]
    return pixels[within], metres[within] * (1.0 + noise * random.normal(size=within.size))
