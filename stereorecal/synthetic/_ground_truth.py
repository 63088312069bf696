"""Ground truth: the disparity and the occlusions of a rendered pair."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from stereorecal.geometry import Camera, StereoRig, View, rectifying_rotations, view as make_view
from stereorecal.synthetic._rig import default_rig
from stereorecal.synthetic.rendering._camera_rays import pixel_grid, world_rays
from stereorecal.synthetic.scenes import make_world
from stereorecal.synthetic.world._raycast import depth


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
    pixels = pixel_grid(view.size)
    ideal = np.concatenate([pixels, np.ones_like(pixels[..., :1])], -1) @ np.linalg.inv(view.matrix_left).T
    directions = ideal @ left_turn
    pose, focal = world.motion.pose(frame), float(view.focal)
    rays = world_rays(pose, rig, 0, directions.astype(np.float32), focal)
    z = depth(world, rays)
    inverse = 1.0 / z.astype(float)
    infinity = float(view.centre_left) - float(view.centre_right)
    disparity = focal * float(rig.baseline) * inverse + infinity

    # Occlusion: cast the ray from the right camera to each point. The sky, put at 1e5 m, is hidden by what stands
    # before it as well; half a percent of the depth is tolerated for rounding.
    near = np.isfinite(z)
    points = directions * np.where(near, z, 1e5)[..., None]
    in_right = points @ rig.rotation.T + rig.translation
    back = in_right / np.maximum(in_right[..., 2:], 1e-6)
    second = world_rays(pose, rig, 1, back.astype(np.float32), focal)
    first_met = depth(world, second)
    hidden = first_met < 0.995 * in_right[..., 2]
    return GroundTruth(disparity.astype(np.float32), hidden | ~_inside(rig.right, back, in_right[..., 2]))


def _inside(camera: Camera, rays: Float[np.ndarray, "h w 3"], z: Float[np.ndarray, "h w"]) -> Bool[np.ndarray, "h w"]:
    """Mask of the rays (x/z, y/z, 1), camera frame, at depth z [m] that project into the image."""
    within = (z > 0) & (np.sum(rays[..., :2] ** 2, -1) < float(camera.lens_radius) ** 2)
    pixels = camera.project(np.where(within[..., None], rays, [0.0, 0.0, 1.0]))
    limit = np.array(camera.size) - 1.0
    return within & np.all((pixels >= 0.0) & (pixels <= limit), axis=-1)
