"""Groups of options that several commands share."""

from importlib import import_module
from pathlib import Path
from typing import Literal

from stereorecal._errors import InputError, check_exists, existing_folder
from stereorecal.cli._option_values import (
    camera_pair,
    degrees_and_fraction,
    image_size,
    matcher_name,
    number_or_all,
    seed,
    slice_of_pairs,
    tolerances,
    view_arguments,
    yes_or_no,
)
from stereorecal.cli._options import (
    DECISION,
    DEPTH,
    PAIRS,
    QUOTED,
    READS,
    RIG,
    RUNNING,
    SEARCH,
    TWO_FILES,
    WRITES,
    CommonOptions,
    argument,
    option,
    option_group,
    value_of,
)
from stereorecal.cli._places import calibration_path, check_calibration, check_places, named_inputs

FREE = "what may move: rotation, extrinsics, intrinsics, or names such as pitch,left.k1"
FORMATS = (
    "opencv, ros, kalibr, kitti-raw, kitti-odometry, middlebury, euroc, basalt, depthai, boofcv, stereorecal, matlab, "
    "mrcal, vins, orbslam, foundationstereo, zed, realsense, camera_info"
)
_LAYOUTS = "scene folder, plain log, KITTI raw, KITTI odometry, KITTI stereo, EuRoC, or one of a plug-in"


@option_group
class ReportOptions(CommonOptions):
    """What a command reports, and where."""

    json: str | None = option(WRITES, "everything, as JSON", metavar="FILE|-", writes=True)
    force: bool = option(WRITES, "replace existing files, but none that is read", False)
    quiet: bool = option(WRITES, "no progress and no report", False)

    @property
    def prints(self) -> bool:
        """Whether a report goes to stdout."""
        return not self.quiet and self.json != "-"

    def tell(self, line: object) -> None:
        """Print a line of the report."""
        if self.prints:
            print(line)

    def check(self) -> None:
        super().check()
        check_places(self.places, force=self.force)


@option_group
class CalibrationOptions(CommonOptions):
    """How a calibration file is read."""

    format: str | None = option(READS, f"of the calibration file (default: recognised): {FORMATS}", metavar="FORMAT")
    unit: str | None = option(
        READS,
        "of its lengths: m, cm, mm, in (default: that of the format, or, if it has none, inferred from the baseline)",
        metavar="UNIT",
    )
    cameras: str | None = option(
        READS,
        "the left and the right one of a file that has more, or the right one first: cam2,cam3, cam1,cam0, or in any "
        "format right,left",
        metavar="L,R",
        reads=camera_pair,
    )


@option_group
class CalibrationSizeOptions(CalibrationOptions):
    """How a calibration file without images is read."""

    size: str | None = option(READS, "of the images, if the calibration states none", metavar="WxH", reads=image_size)


@option_group
class RecordingOptions(CalibrationOptions):
    """The recordings that a command is about, and which of their pairs."""

    forms = ("SCENE [SCENE …]", "--left L --right R --calibration FILE")

    scenes: tuple[str, ...] = argument(
        READS,
        f"folder with images and their calibration: {_LAYOUTS} (layouts: page Your data); A+B: two folders, or more, "
        "of one rig that did not drift in between, as one recording (--pairs and --limit are of each folder)",
        (),
        metavar="SCENE",
    )
    left: str | None = option(
        READS,
        "left images, if they are in no scene folder: a file, a folder, 'left/*.png', a video, or a topic of --bag",
        metavar="FILES",
    )
    right: str | None = option(READS, "right images", metavar="FILES")
    side_by_side: str | None = option(READS, "instead: images or a video with both side by side", metavar="FILES")
    bag: str | None = option(
        READS, "of ROS 1 (file) or ROS 2 (folder), whose topics --left and --right are", metavar="BAG"
    )
    calibration: tuple[str, ...] | None = option(
        READS,
        "calibration of these images, or of scene folders instead of theirs: one file, or one for each camera (default "
        "for a bag: its camera_info)",
        metavar="FILE",
        reads=calibration_path,
    )
    tolerance: float | None = option(
        READS,
        "between the two frames of a pair (default: a quarter of the time between frames; image files are paired by "
        "name unless this is given)",
        metavar="SECONDS",
    )
    pairs: str | None = option(
        PAIRS,
        "a pair, or a slice of them: 7, 10:50, 100: or ::5, every fifth (default: all)",
        metavar="A:B:N",
        reads=slice_of_pairs,
    )
    limit: str | None = option(
        PAIRS,
        "of those the N with the most texture, one from each Nth part (default: 24 of a video, a bag or more than 100 "
        "pairs, else all; of monitor all)",
        metavar="N|all",
        reads=number_or_all,
    )

    @property
    def image_inputs(self) -> list[Path]:
        """The images, videos and bags that are named by themselves, and may be read only later."""
        return named_inputs(self.left, self.right, self.side_by_side, self.bag)

    def stretch(self) -> slice:
        """The pairs that --pairs selects."""
        return value_of(self, "pairs", slice(0, None, 1))

    def check_recordings(self) -> None:
        """Refuse recordings that are named incompletely, or are not there."""
        ways = (("bag", "left", "right"),) if self.bag else (("left", "right"), ("side_by_side",))
        begun = [way for way in ways if any(getattr(self, name) is not None for name in way)]
        given, missing = [], []
        of_bag = self.bag is not None and self.calibration is None  # whose camera_info is one
        for name in (*(begun[0] if begun else ()), *(() if of_bag else ("calibration",))):
            (given if getattr(self, name) is not None else missing).append(f"--{name.replace('_', '-')}")
        if self.scenes and begun:
            images = import_module("stereorecal.io").IMAGE_SUFFIXES
            why = QUOTED if Path(self.scenes[0]).suffix.lower() in images else TWO_FILES
            raise InputError(
                f"give scene folders or {' and '.join(given)}, not both; {self.scenes[0]} is taken for a scene folder "
                f"({why})."
            )
        if not (self.scenes or given):
            raise InputError("give scene folders, or --left, --right and --calibration together.")
        if len(begun) > 1 or (self.bag and self.side_by_side):
            raise InputError("--left and --right, --side-by-side, or --bag: give one of these.")
        if given and not begun and not self.scenes:
            raise InputError("--calibration needs images: --left and --right, --side-by-side, or --bag; add them.")
        if begun and missing:
            needs, add = ("needs", "need")[len(given) > 1], ("it", "them")[len(missing) > 1]
            raise InputError(f"{' and '.join(given)} {needs} {' and '.join(missing)}; add {add}.")
        if self.calibration is None and (self.format or self.cameras or (self.unit and not self.bag)):
            names = "--format and --cameras" if self.bag else "--format, --unit and --cameras"
            raise InputError(f"{names} belong to --calibration; leave them out.")
        if self.scenes and self.tolerance is not None:
            raise InputError(
                "--tolerance belongs to --left and --right, or --bag; a scene folder pairs by names: leave it out."
            )
        for folder in (folder for scene in self.scenes for folder in folders_of(scene)):
            existing_folder(folder)
        for place in (self.bag,) if self.bag else (self.left, self.right, self.side_by_side):
            if place is not None:
                check_exists(place, "file or folder")
        if self.calibration is not None:
            check_calibration(self.calibration, "--calibration")


def folders_of(scene: str) -> list[str]:
    """The folders that one recording consists of; refuses one of several that has no name, or is named twice."""
    folders = [scene] if Path(scene).exists() else scene.split("+")
    if len({Path(folder).resolve() for folder in folders}) < len(folders) or (len(folders) > 1 and "" in folders):
        raise InputError(f"{scene}: A+B joins different folders; name each once.")
    return folders


@option_group
class MatcherOptions(CommonOptions):
    """The stereo matcher."""

    matcher: str = option(
        SEARCH, "installed stereo matcher: sad, bm, sgbm, or a plug-in's", "sad", metavar="NAME", reads=matcher_name
    )


@option_group
class JudgingOptions(MatcherOptions):
    """How a calibration is seen, and what counts as better, as worse and as good."""

    tolerances: str | None = option(
        DECISION,
        "limits, such as harm=0.01,rows_px=0.1: rows_px, depth_points, gains, leaves, better, harm, predicts, "
        "good_rows_px, good_surely; distances=5:10:30 in baselines",
        metavar="NAME=N,…",
        reads=tolerances,
    )
    view: str | None = option(
        SEARCH,
        "the rectified images, as of sr.view: projection=pinhole or equirectangular, field=DEGREES (default: pinhole; "
        "equirectangular for lenses that are too wide for it)",
        metavar="NAME=VALUE,…",
        reads=view_arguments,
    )


@option_group
class HealthOptions(ReportOptions, RecordingOptions, JudgingOptions):
    """What `sr.health` takes, and `sr.recalibrate` as well; and mistakes that are corrected before."""

    fix: Literal["exchanged", "turned", "scaled", "late", "early"] | None = option(
        READS, "correct the mistake that a report names: exchanged, turned, scaled, late or early", metavar="CAUSE"
    )
    prior: str | None = option(
        RIG,
        "how well the initial calibration is known: saved (by an earlier repair), default (as after a chessboard "
        "calibration), exact (every epipolar error is a drift); default: saved, if it was",
        metavar="NAME",
    )
    motion: Literal["auto", "on", "off"] = option(
        DEPTH,
        "use the motion of the rig between pairs: auto (if times are known and at most 0.5 s apart), on (pairs are "
        "consecutive), off (default: auto)",
        "auto",
        reads=yes_or_no,
    )
    distances: str | None = option(
        WRITES,
        "at which errors of depth are reported, such as 2m,50cm, or baselines, such as 30 (default: near, middle and "
        "far of what the images show)",
        metavar="LENGTH,…",
    )

    def check(self) -> None:
        self.check_recordings()
        if self.fix is not None and len(self.scenes) > 1:
            raise InputError("--fix corrects one recording; give one.")
        if self.fix in ("late", "early") and (self.stretch().step > 1 or self.limit not in (None, "all")):
            raise InputError(
                f"--fix {self.fix} needs pairs that follow each other; leave steps of --pairs and --limit out."
            )
        super().check()


@option_group
class ReachOptions(CommonOptions):
    """How far a search goes."""

    reach: str = option(
        RIG, "how far the rig may have drifted", "3,0.03", metavar="DEG,FRACTION", reads=degrees_and_fraction
    )


@option_group
class ExecutorOptions(CommonOptions):
    """Who does the work."""

    executor: str = option(
        RUNNING, "serial, threads:N, processes:N or dask:ADDRESS (of a scheduler)", "serial", metavar="SPEC"
    )


@option_group
class WorkerOptions(ExecutorOptions):
    """Who does the work, and with which random numbers."""

    seed: int = option(RUNNING, "same seed, same result", 0, metavar="N", reads=seed)
