"""A reconstruction of a rig of two cameras in frames that stand by themselves, and its bundle adjustment."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pycolmap

from stereorecal_colmap._colmap import Colmap
from stereorecal_colmap._matches import Matches


@dataclass(frozen=True, eq=False)
class Adjusted:
    """What a bundle adjustment ended with.

    Attributes:
        pose: of the right camera from the left one; its length means nothing.
        points: how many are kept.
        error: their mean reprojection error [px].
    """

    pose: pycolmap.Rigid3d
    points: int
    error: float


def adjusted(how: Colmap, cameras: Sequence[pycolmap.Camera], pose: pycolmap.Rigid3d, matches: Matches) -> Adjusted:
    """Triangulate, filter and adjust in turn, from a pose of the right camera."""
    points, error = 0, np.inf
    for _ in range(how.max_refinements):
        rig = _triangulated(cameras, pose, matches)
        observations = pycolmap.ObservationManager(rig)
        observations.filter_all_points3D(how.max_reproj_error, how.min_tri_angle)
        if rig.num_points3D() < how.min_matches:
            break
        _adjust(rig)
        changed = observations.filter_all_points3D(how.max_reproj_error, how.min_tri_angle)
        changed += 2 * abs(rig.num_points3D() - points)
        pose, points = rig.rig(1).non_ref_sensors[cameras[1].sensor_id] or pose, rig.num_points3D()
        rig.update_point_3d_errors()
        error = float(rig.compute_mean_reprojection_error()) if points else np.inf
        if changed <= how.max_refinement_change * 2 * points:
            break
    return Adjusted(pose, points, error)


def _triangulated(
    cameras: Sequence[pycolmap.Camera], pose: pycolmap.Rigid3d, matches: Matches
) -> pycolmap.Reconstruction:
    """A frame for each number of a frame, all at the origin, with a point for each match that can be triangulated."""
    made = pycolmap.Reconstruction()
    for camera in cameras:
        made.add_camera(camera)
    rig = pycolmap.Rig(rig_id=1)
    rig.add_ref_sensor(cameras[0].sensor_id)
    rig.add_sensor(cameras[1].sensor_id, pose)
    made.add_rig(rig)
    seen = list(zip(cameras, (matches.left, matches.right), strict=True))
    rays = [np.asarray(camera.cam_ray_from_img(side)) for camera, side in seen]
    for number in np.unique(matches.frame):
        members = np.flatnonzero(matches.frame == number)
        images = [2 * int(number) + 1, 2 * int(number) + 2]
        frame = pycolmap.Frame(frame_id=int(number) + 1, rig_id=1)
        sides = [
            pycolmap.Image(name=f"{image}", keypoints=side[members], camera_id=camera.camera_id, image_id=image)
            for image, camera, side in zip(images, *zip(*seen, strict=True), strict=True)
        ]
        for side in sides:
            side.frame_id = frame.frame_id
            frame.add_data_id(side.data_id)
        frame.rig_from_world = pycolmap.Rigid3d()
        made.add_frame(frame)
        for side in sides:
            made.add_image(side)
        for index, member in enumerate(members):
            point = pycolmap.triangulate_mid_point(pose, rays[0][member], rays[1][member])
            if point is not None:
                elements = [pycolmap.TrackElement(image, index) for image in images]
                made.add_point3D(point, pycolmap.Track(elements))
    return made


def _adjust(rig: pycolmap.Reconstruction) -> None:
    """Move the right camera in the rig, and all points; the frames are the gauge, intrinsics stay."""
    options = pycolmap.BundleAdjustmentOptions(
        refine_focal_length=False, refine_principal_point=False, refine_extra_params=False, print_summary=False
    )
    config = pycolmap.BundleAdjustmentConfig()
    for image in rig.images:
        config.add_image(image)
    for frame in rig.frames:
        config.set_constant_rig_from_world_pose(frame)
    # Of the gauge nothing but the scale is left, which COLMAP's own ways of fixing it do not know in a rig that moves.
    rig.update_point_3d_errors()
    config.add_constant_point(min(rig.points3D, key=lambda number: rig.points3D[number].error))
    pycolmap.create_default_bundle_adjuster(options, config, rig).solve()
