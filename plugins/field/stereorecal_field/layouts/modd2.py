"""MODD2: raw sequences from a boat, each with its own calibration."""

from pathlib import Path

from stereorecal.io.layouts import Hints, Sequence, load_matched, log_of, natural_order, read_files
from stereorecal.recordings import Log
from stereorecal_field.layouts._marked_images import match_marked

LAYOUT = "MODD2 (video_data/NAME), or one sequence of it (calibration.yaml, frames/NNNNNNNNL.jpg and R.jpg)"
_CALIBRATION, _FRAMES, _SEQUENCES = "calibration.yaml", "frames", "video_data"
_UNIT = "mm"


def recognises(folder: Path) -> bool:
    """Whether the folder is MODD2 or one of its sequences."""
    return any((folder / _SEQUENCES).glob(f"*/{_FRAMES}")) or _is_sequence(folder)


def read(folder: Path, limit: int | None) -> Log:
    """The raw frames of each sequence; `framesRectified` is not read.

    Raises:
        InputError: naming the file, if something is missing or damaged.
    """
    if _is_sequence(folder):
        return log_of(folder, [_sequence(folder, limit)])
    places = natural_order(frames.parent for frames in (folder / _SEQUENCES).glob(f"*/{_FRAMES}"))
    return log_of(folder, (_sequence(place, limit) for place in places))


def _is_sequence(folder: Path) -> bool:
    return (folder / _CALIBRATION).is_file() and (folder / _FRAMES).is_dir()


def _sequence(folder: Path, limit: int | None) -> Sequence:
    pairs = load_matched(match_marked(folder / _FRAMES), limit)
    rig = read_files([folder / _CALIBRATION], "opencv", _UNIT, Hints(size=pairs[0].size))
    return folder, rig, pairs
