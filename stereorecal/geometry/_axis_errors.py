"""How far one rig is from another, axis by axis: the one definition that tables and JSON files use."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from stereorecal.geometry._rig import AXES, StereoRig, with_unit_baseline


@dataclass(frozen=True)
class AxisErrors:
    """Absolute differences of the extrinsics of two rigs.

    Attributes:
        rotation_deg: of pitch, yaw and roll, in degrees, by name.
        translation_percent: of y and z, in percent of the baseline, by name. The directions of the baselines are
            compared: images do not show its length.
    """

    rotation_deg: dict[str, float]
    translation_percent: dict[str, float]


def axis_errors(rig: StereoRig, reference: StereoRig) -> AxisErrors:
    """The errors of `rig` when `reference` is right."""
    errors = np.abs(axis_changes(reference, rig))
    by_name = {str(name): float(value) for name, value in zip(AXES, errors, strict=True)}
    return AxisErrors(*({name: by_name[name] for name in names} for names in (AXES[:3], ("y", "z"))))


def axis_changes(before: StereoRig, after: StereoRig) -> Float[np.ndarray, "6"]:
    """What `after` changes against `before`, with its sign: pitch, yaw, roll [degrees], x, y, z of the direction of the
    baseline [percent]. The definition that `axis_errors` rests on."""
    change = with_unit_baseline(after.extrinsics) - with_unit_baseline(before.extrinsics)
    return np.concatenate([np.degrees(change[:3]), 100.0 * change[3:]])
