"""Cameras, rigs, rotations, rectification, warps: pure functions and frozen pytrees."""

from stereorecal.geometry._camera import Camera as Camera, same_camera as same_camera, whole_size as whole_size
from stereorecal.geometry._intrinsics import (
    OF_MATRIX as OF_MATRIX,
    camera_changes as camera_changes,
    changed_camera as changed_camera,
    intrinsic as intrinsic,
    pixel_slopes as pixel_slopes,
    ray_slopes as ray_slopes,
    reread as reread,
)
from stereorecal.geometry._quarter_turns import (
    UPRIGHT as UPRIGHT,
    Turns as Turns,
    described_turns as described_turns,
    turn_of as turn_of,
    turned_pixels as turned_pixels,
    turned_size as turned_size,
    turns_of as turns_of,
)
from stereorecal.geometry._rectified import Rectification as Rectification, rectification as rectification
from stereorecal.geometry._rig import (
    AS_IN_FILE as AS_IN_FILE,
    AXES as AXES,
    StereoRig as StereoRig,
    checked_rig as checked_rig,
    extrinsics_of as extrinsics_of,
    fitted_to as fitted_to,
    rig_as_data as rig_as_data,
    rig_from_data as rig_from_data,
    with_unit_baseline as with_unit_baseline,
)
from stereorecal.geometry._rig_differences import (
    axis_changes as axis_changes,
    axis_errors as axis_errors,
    same_cameras as same_cameras,
    same_rig as same_rig,
)
from stereorecal.geometry._so3 import (
    angle_between as angle_between,
    euler_from_rotation as euler_from_rotation,
    euler_slopes as euler_slopes,
    rectifying_rotations as rectifying_rotations,
    rectifying_slopes as rectifying_slopes,
    rotation_between as rotation_between,
    rotation_from_euler as rotation_from_euler,
    rotation_from_vector as rotation_from_vector,
    vector_from_rotation as vector_from_rotation,
)
from stereorecal.geometry._units import (
    METRES as METRES,
    doubt_of_length as doubt_of_length,
    inferred_unit as inferred_unit,
)
from stereorecal.geometry._view import (
    PINHOLE as PINHOLE,
    AnyView as AnyView,
    View as View,
    as_view as as_view,
    checked_view_arguments as checked_view_arguments,
    view as view,
)
from stereorecal.geometry._warp import (
    PixelMap as PixelMap,
    bilinear_warp as bilinear_warp,
    cubic_sampler as cubic_sampler,
    cubic_warp as cubic_warp,
    mapped_area as mapped_area,
    pixel_map as pixel_map,
    rectifying_maps as rectifying_maps,
)
from stereorecal.geometry.lenses._radial_tangential import distort as distort, undistort as undistort
from stereorecal.geometry.projections import Projection as Projection, projection as projection
