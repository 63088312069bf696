"""Values of a calibration that hardly any rig has: a unit mistaken, a digit too many."""

import numpy as np

from stereorecal.geometry import Camera, StereoRig

_FIELD = (10.0, 140.0)  # degrees that a lens without fisheye model sees from left to right
_LEAST_CIRCLE = 0.25  # of the shorter side of the image: the radius of an image circle
_ALL_ROUND = 3.1  # radians off the axis: straight behind, a lens model has no direction
_BASELINE = (0.002, 5.0)  # metres


def doubts(rig: StereoRig) -> tuple[str, ...]:
    """Sentences, each with what to check. Whether the rig is aligned is another question: rows know neither the length
    of the baseline nor, both changed alike, focal lengths."""
    found = [said for side in ("left", "right") if (said := _of_field(side, getattr(rig, side))) is not None]
    baseline = float(rig.baseline)
    if not _BASELINE[0] <= baseline <= _BASELINE[1]:
        found.append(f"the cameras would be {baseline:.3g} m apart; check the unit of the translation")
    return tuple(found)


def _of_field(side: str, camera: Camera) -> str | None:
    width, focal, wide = camera.size[0], float(np.asarray(camera.focal)[0]), camera.lens.WIDE
    field = np.degrees(width / focal if wide else 2.0 * np.arctan(width / 2.0 / focal))
    if field < _FIELD[0] or (field > _FIELD[1] and not wide):
        return (
            f"a focal length of {focal:.4g} px in {width} px wide images is a view of {field:.0f} degrees; "
            f"check fx of the {side} camera"
        )
    return _of_fold(side, camera) if wide else None


def _of_fold(side: str, camera: Camera) -> str | None:
    """The end of a wide lens' model lies beyond most of the image, or at its image circle."""
    end = min(float(camera.lens_field), _ALL_ROUND)
    aside, _ = camera.project(np.array([np.sin(end), 0.0, np.cos(end)])) - np.asarray(camera.matrix)[:2, 2]
    if not aside < _LEAST_CIRCLE * min(camera.size):
        return None
    return (
        f"the coefficients of the {camera.model} lens fold the image back {np.degrees(end):.0f} degrees off its axis, "
        f"{aside:.0f} px from the middle; check those of the {side} camera"
    )
