"""A scene from its parts: image pairs and a calibration that fits them, with what else its file says of the scene."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from stereorecal._errors import CalibrationWarning, InputError, warn
from stereorecal.geometry import StereoRig
from stereorecal.io._read_files import AnyPath, about, check_there
from stereorecal.io.formats import _stereorecal
from stereorecal.io.formats._format import Hints
from stereorecal.io.formats._load_rig import documents_of, paths_of, rig_of_documents, warn_of_file
from stereorecal.io.formats._numbers import image_size
from stereorecal.io.formats._read_rig import at_common_size, checked_cameras, named, rig_in
from stereorecal.io.formats._rig_file import KEY
from stereorecal.io.formats.text._document import Syntax, document
from stereorecal.io.images._bags import bag_folder, camera_infos
from stereorecal.io.images._load_pairs import Sizes, common_size
from stereorecal.recordings import LazyPairs, Pair, Scene, check_pairs


@dataclass(frozen=True, eq=False)
class Calibration:
    """The content of a calibration file."""

    rig: StereoRig | None  # side by side; None if both camera matrices of a calib.json are null
    reference: str = "stored"  # or "truth", if the rig is exact, such as that of a rendered scene
    info: Mapping[str, Any] = field(default_factory=dict)  # other keys of a calib.json, unchanged
    stated: tuple[int, int] = (0, 0)  # (width, height) of the images, where there is no rig

    @property
    def sizes(self) -> Sizes:
        """(width, height) of the left and of the right images as they were taken."""
        return (self.stated, self.stated) if self.rig is None else self.rig.sizes_taken


def load_calibration(paths: Sequence[Path], format: str | None, unit: str | None, hints: Hints) -> Calibration:
    """The calibration in files as `read_files` takes them; a calib.json may lack the rig."""
    rig, size = None, (0, 0)
    documents, found = documents_of(paths, format, hints)
    own = documents[0].content if found is _stereorecal.FORMAT else {}
    if own.get("K_left", ()) is None and own.get("K_right", ()) is None:
        with about(documents[0].name):
            size = image_size(own, "image_size")
    else:
        rig = rig_of_documents(documents, found, unit, hints).side_by_side()
    known = {*_stereorecal.KEYS, "reference", KEY}
    info = {key: item for key, item in own.items() if key not in known}
    return Calibration(rig, "truth" if own.get("reference") == "truth" else "stored", info, size)


def calibrated_scene(
    name: str,
    pairs: Callable[[Sizes | None], Sequence[Pair]],
    calibration: AnyPath | tuple[AnyPath, AnyPath],
    *,
    format: str | None = None,
    unit: str | None = None,
    cameras: tuple[str, str] | None = None,
) -> Scene:
    """The scene of pairs in any place, and a calibration in any format that `load_rig` reads: without image size it is
    for images of this size; where it says two, the larger images are read at the smaller size, and `save_rig` writes
    the file's own.

    Args:
        pairs: reads them, once it is sure that there is a file of a calibration, for the sizes of the left and the
            right camera, or None, such as `lambda sizes: load_pairs(left, right, sizes=sizes)`.
        calibration: a file, a folder that holds one, or the left and the right camera's file.
        format, unit, cameras: as of `load_rig`.

    Raises:
        InputError, UnsupportedModelError: as `load_rig`, and as `pairs` does.

    Warns:
        CalibrationWarning: as `load_rig`.
    """
    paths = paths_of(calibration)
    for path in paths:
        check_there(path)
    where, hints = " and ".join(map(str, paths)), Hints(cameras=checked_cameras(cameras))
    scene = _assembled(name, pairs, where, lambda hints: load_calibration(paths, format, unit, hints), hints)
    warn_of_file(where, scene.rig)
    return scene


def bag_scene(
    bag: AnyPath,
    topics: tuple[str, str],
    pairs: Callable[[Sizes | None], Sequence[Pair]],
    *,
    unit: str | None = None,
) -> Scene:
    """The scene of pairs of a bag, with the calibration in its own camera_info; the rig is that of no file. Warns as
    `load_rig`; InputError if there is no such camera_info, or it is no calibration of these images."""
    place = bag_folder(Path(bag))
    infos = camera_infos(place, topics).items()
    documents = tuple(document(f"{place}, {topic}", text, Syntax.JSON) for topic, text in infos)

    def load(hints: Hints) -> Calibration:
        return Calibration(replace(rig_in(documents, named("ros"), unit, hints).side_by_side(), source=None))

    scene = _assembled(str(place), pairs, str(place), load, Hints())
    warn_of_file(place, scene.rig)
    return scene


def _assembled(
    name: str,
    pairs: Callable[[Sizes | None], Sequence[Pair]],
    where: str,
    load: Callable[[Hints], Calibration],
    hints: Hints,
) -> Scene:
    """The scene of pairs and of what `load` finds, about `where`, which may depend on the size of the images."""
    try:
        sizes = load(hints).sizes
        # A calibration that is scaled to images of any size says none for each camera.
        if sizes[0] != sizes[1] and load(replace(hints, size=common_size(sizes))).sizes != sizes:
            sizes = None
    except InputError:  # which is said below
        sizes = None
    read = pairs(sizes)
    found = load(replace(hints, size=read[0].size if read else None))
    found = replace(found, rig=None if found.rig is None else at_common_size(found.rig))
    if found.rig is not None and not read:
        with about(where):
            check_pairs(found.rig, read)  # says that there is none
    fitted = tuple(_fitting(where, found, pair) for pair in read)
    remark_sizes(where, sizes)
    return Scene(name, found.rig, fitted, found.reference, found.info)


def remark_sizes(where: str, sizes: Sizes | None) -> None:
    """Say that the cameras of a calibration have images of two sizes."""
    if sizes is not None and sizes[0] != sizes[1]:
        (left, right), (width, height) = (f"{wide}x{high}" for wide, high in sizes), common_size(sizes)
        warn(
            f"{where}: the images are {left} (left) and {right} (right); the larger are read at {width}x{height}, and "
            "the file keeps its sizes.",
            CalibrationWarning,
        )


def fitting(where: Path, calibration: Calibration, pairs: LazyPairs) -> LazyPairs:
    """The pairs, each turned and checked when it is read; messages begin with `where`."""
    return pairs.mapped(partial(_fitting, where, calibration))


def _fitting(where: Path | str, calibration: Calibration, pair: Pair) -> Pair:
    width, height = calibration.sizes[0]
    with about(where):
        if pair.size == (height, width) != (width, height):
            raise InputError(
                f"{pair.name}: the images are {height}x{width}, but the calibration is for {width}x{height}; the "
                "images are turned by 90 degrees, or those of the calibration were: turn them alike (cv2.rotate)."
            )
        if calibration.rig is not None:
            return check_pairs(calibration.rig, pair)[0]
        if pair.size != (width, height):
            raise InputError(f"an image is not {width}x{height} as the calibration says; correct one of them.")
    return pair
