"""Values of a calibration that hardly any rig has: a unit mistaken, a digit too many."""

import numpy as np

from stereorecal.geometry import Camera, StereoRig

_FIELD = (10.0, 140.0)  # degrees that a lens without fisheye model sees from left to right
_BASELINE = (0.002, 5.0)  # metres


def doubts(rig: StereoRig) -> tuple[str, ...]:
    """Sentences, each with what to check. Whether the rig is aligned is another question: rows know neither the length
    of the baseline nor, both changed alike, focal lengths."""
    found = [sentence for side in ("left", "right") if (sentence := _of_field(side, getattr(rig, side))) is not None]
    baseline = float(rig.baseline)
    if not _BASELINE[0] <= baseline <= _BASELINE[1]:
        found.append(f"the cameras would be {baseline:.3g} m apart; check the unit of the translation")
    return tuple(found)


def _of_field(side: str, camera: Camera) -> str | None:
    width, focal, wide = camera.size[0], float(np.asarray(camera.focal)[0]), camera.lens.WIDE
    field = np.degrees(width / focal if wide else 2.0 * np.arctan(width / 2.0 / focal))
    if _FIELD[0] <= field and (field <= _FIELD[1] or wide):
        return None
    return (
        f"a focal length of {focal:.4g} px in {width} px wide images is a view of {field:.0f} degrees; "
        f"check fx of the {side} camera"
    )
