"""ROS camera_info of both cameras in one file: messages that were printed one after the other, or ost.txt, which
camera_calibration writes beside its YAML files (read only)."""

from stereorecal._errors import InputError
from stereorecal.geometry import StereoRig
from stereorecal.io.formats import _ros
from stereorecal.io.formats._format import Documents, Hints, Target
from stereorecal.io.formats.text._document import Syntax

NAME = "camera_info"
ABOUT = "ROS camera_info of both cameras in one file (echoed messages, ost.txt)"
SYNTAX = {".yaml": Syntax.YAML, ".yml": Syntax.YAML}
FILES = 1
UNIT = "m"


def can_read(documents: Documents) -> bool:
    """Whether there are two cameras or more."""
    return len(documents) == 1 and len(_ros.parts_of(documents[0])) > 1


def cameras(documents: Documents) -> tuple[str, ...]:
    """The names of the cameras, or their numbers where these are not different names."""
    names = tuple(part.name for part in _ros.parts_of(documents[0]))
    return names if all(names) and len(set(names)) == len(names) else tuple(map(str, range(len(names))))


def read(documents: Documents, hints: Hints) -> StereoRig:
    """The rig of two camera_infos, left before right unless the hints name them."""
    return _ros.rig_of_parts(*(part.document for part in _both(documents, hints)))


def _both(documents: Documents, hints: Hints) -> tuple[_ros.Part, _ros.Part]:
    parts, names = _ros.parts_of(documents[0]), cameras(documents)
    if len(parts) > 2:
        raise InputError(
            f"it has {len(parts)} calibrations that differ ({', '.join(names)}); keep those of the left and the right "
            "camera."
        )
    left, right = hints.cameras or names[:2]
    return parts[names.index(left)], parts[names.index(right)]


def blank(rig: StereoRig, syntax: Syntax) -> tuple[str, ...]:
    """One file, a YAML document for each camera."""
    return ("---\n".join(_ros.blank(rig, syntax)),)


def write(rig: StereoRig, target: Target) -> tuple[str, ...]:
    """Both cameras, as `_ros.write`."""
    left, right = _ros.values_of(rig, target, *_both(target.documents, target.hints))
    return (target.documents[0].with_values({**left, **right}),)
