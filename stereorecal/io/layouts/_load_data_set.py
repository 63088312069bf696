"""The list of layouts: which one a folder has, and reading it as a log or a scene."""

from collections.abc import Callable
from pathlib import Path
from typing import Protocol, runtime_checkable

from stereorecal._errors import InputError, existing_folder
from stereorecal._plugins import entry_points, install_line
from stereorecal.io._read_files import AnyPath
from stereorecal.io.formats._load_rig import warn_of_file
from stereorecal.io.layouts import _data_sets, _own_folders
from stereorecal.io.layouts._own_folders import folder_name, is_scene_folder, open_scene_folder
from stereorecal.recordings import LazyPairs, Log, Mission, Pair, Scene


@runtime_checkable
class Layout(Protocol):
    """A module, or an object, that recognises a folder by what is in it and reads it as a log."""

    @property
    def LAYOUT(self) -> str:
        """Its name and its files, for the message about a folder that no layout recognises: a constant."""
        ...

    def recognises(self, folder: Path, /) -> bool:
        """Whether the folder has this layout. Looks at names only, and opens no file."""
        ...

    def read(self, folder: Path, limit: int | None, /) -> Log:
        """The log in the folder, of each sequence the first `limit` pairs or all."""
        ...


# The first that recognises a folder reads it. KITTI stereo comes before odometry: both have folders such as image_0,
# but only the names of its images end in _10.
_LAYOUTS: tuple[Layout, ...] = (
    _own_folders,
    _data_sets.KITTI_RAW,
    _data_sets.KITTI_STEREO,
    _data_sets.KITTI_ODOMETRY,
    _data_sets.EUROC,
)
_GROUP = "stereorecal.layouts"
_INSTALL = f"run: {install_line('field')}"
_OF_FIELD = ("im0.png", "*/im0.png", "frames/*L.jpg", "video_data/*/frames", "calibration/calibration-*.yaml")


def load_log(folder: AnyPath, limit: int | None = None) -> Log:
    """The log of missions in a folder; its layout is recognised by the names of folders and files in it.

    A scene folder is a log of one mission. `docs/data.md` describes the other layouts.

    Pairs are read each time they are used (`LazyPairs`), so that a log may be larger than the memory: the first pair of
    each mission is checked now, any other when it is read.

    Args:
        limit: only the first `limit` pairs of each mission.

    Raises:
        InputError: naming the file, if no layout is recognised, or something is missing or damaged.
        UnsupportedModelError: if the model of a lens is not known.

    Warns:
        CalibrationWarning: as `load_rig`.
    """
    folder = existing_folder(folder)
    if is_scene_folder(folder):
        found, pairs = open_scene_folder(folder, limit)
        name = folder_name(folder)
        if found.rig is None:
            raise InputError(f"{name}: the scene has no calibration; a log needs one.")
        truth = found.rig if found.reference == "truth" else None
        log = Log(name, {"stored": found.rig}, (Mission(name, "stored", pairs, truth=truth),))
    elif (layout := _layout_of(folder)) is not None:
        log = layout.read(folder, limit)
    else:
        known = "; ".join(layout.LAYOUT for layout in _layouts())
        raise InputError(
            f"{folder}: the layout is unknown; expected a scene folder (calib.json, left, right), or {known}."
        )
    warn_of_file(folder, *log.calibrations.values(), sized=False)
    return log


def load_scene(
    folder: AnyPath, limit: int | None = None, *, choose: Callable[[LazyPairs], tuple[Pair, ...]] = tuple
) -> Scene:
    """The scene in a folder: calib.json and `left.*`, `right.*`, or folders `left`, `right` with equal names.

    calib.json holds `image_size` [w, h], `K_left`, `D_left`, `K_right`, `D_right` (OpenCV's order),
    `distortion_model`, `R` and `T` [m] with `x_right = R x_left + T`. If both K are null the scene has
    no rig. Keys that do not describe the rig are in `Scene.info`, unchanged. The name is "<parent>/<folder>".
    A folder in another layout that `load_log` knows is a scene too, if it holds one sequence.

    Args:
        limit: read only the first `limit` pairs.
        choose: is given the pairs, read when it asks for them, and returns the ones of the scene; default all. What it
            does not keep takes no memory.

    Raises:
        InputError: naming the file, if something is missing, unreadable, damaged or contradicts itself.
        UnsupportedModelError: if the model of a lens is not known.

    Warns:
        CalibrationWarning: as `load_rig`.
    """
    folder = existing_folder(folder)
    layout = None if is_scene_folder(folder) else _layout_of(folder)
    if layout is None:
        found, pairs = open_scene_folder(folder, limit)
        scene = Scene(folder_name(folder), found.rig, choose(pairs), found.reference, found.info)
    else:
        log = layout.read(folder, limit)
        mission, *others = log.missions
        if others:
            raise InputError(
                f"{folder}: {len(log.missions)} sequences are in there ({mission.name} …); give the folder of one of "
                "them."
            )
        assert isinstance(mission.pairs, LazyPairs)
        scene = Scene(mission.name, log.calibration_of(mission), choose(mission.pairs))
    warn_of_file(folder, scene.rig, sized=False)
    return scene


def is_data_set(folder: AnyPath) -> bool:
    """Whether a folder has a layout of `load_log` that is not a scene folder's."""
    folder = Path(folder)
    return not is_scene_folder(folder) and _layout_of(folder) is not None


def _layout_of(folder: Path) -> Layout | None:
    """The first that recognises a folder."""
    found = next((layout for layout in _layouts() if layout.recognises(folder)), None)
    missing = found is None and "modd2" not in entry_points(group=_GROUP).names
    if missing and any(any(folder.glob(pattern)) for pattern in _OF_FIELD):
        raise InputError(f"{folder}: to read MODD2, MODS and Middlebury, {_INSTALL}.")
    return found


def _layouts() -> tuple[Layout, ...]:
    """Those above, and the modules that entry points of distributions name."""
    return (*_LAYOUTS, *(point.load() for point in entry_points(group=_GROUP)))
