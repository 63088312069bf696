"""MODS: raw sequences from a boat, and a folder of calibrations that many of them share."""

from pathlib import Path

from stereorecal.io.layouts import Hints, Sequence, load_matched, log_of, natural_order, read_files
from stereorecal.recordings import Log
from stereorecal_field.layouts._marked_images import match_marked

LAYOUT = "MODS (calibration/calibration-ID.yaml, sequences/ID-.../frames/NNNNNNNNL.jpg and R.jpg)"
_CALIBRATIONS, _SEQUENCES, _FRAMES = "calibration", "sequences", "frames"
_UNIT = "mm"


def recognises(folder: Path) -> bool:
    """Whether the folder is MODS."""
    return any((folder / _CALIBRATIONS).glob("calibration-*.yaml")) and (folder / _SEQUENCES).is_dir()


def read(folder: Path, limit: int | None) -> Log:
    """The sequences. The name of each begins with that of its calibration: "kope100-00006790-00007090" has
    calibration-kope100.yaml. Its images are in its folder `frames`, or in the sequence's folder itself.

    Raises:
        InputError: naming the file, if something is missing or damaged.
    """
    places = natural_order(path for path in (folder / _SEQUENCES).iterdir() if path.is_dir())
    return log_of(folder, (_sequence(folder, place, limit) for place in places))


def _sequence(root: Path, place: Path, limit: int | None) -> Sequence:
    frames = place / _FRAMES
    pairs = load_matched(match_marked(frames if frames.is_dir() else place), limit)
    identity = place.name.partition("-")[0]
    path = root / _CALIBRATIONS / f"calibration-{identity}.yaml"
    return place, read_files([path], "opencv", _UNIT, Hints(size=pairs[0].size)), pairs
