"""Groups of options that several commands share."""

from typing import Literal

from stereorecal.cli._options import argument, option, option_group

FREE = "what may move: rotation, extrinsics, intrinsics (shared by all recordings), pitch, left.k1 …; by commas"
FORMATS = "opencv, ros, kalibr, kitti-raw, kitti-odometry, middlebury, euroc, basalt, depthai, boofcv, stereorecal"
_LAYOUTS = "scene folder, plain log, MODD2, MODS, KITTI raw, KITTI odometry, KITTI stereo, EuRoC, Middlebury"


@option_group
class ReportOptions:
    """What a command reports, and where."""

    json: str | None = option("write everything as JSON", metavar="FILE|-")
    force: bool = option("files that exist may be replaced, but none that is read", False)
    quiet: bool = option("no progress and no report", False)

    @property
    def prints(self) -> bool:
        """Whether a report goes to stdout."""
        return not self.quiet and self.json != "-"


@option_group
class CalibrationFormatOptions:
    """How a calibration file is read."""

    format: str | None = option(f"of the calibration file (default: recognised): {FORMATS}", metavar="FORMAT")
    unit: str | None = option(
        "of lengths in a calibration that states none, read or written: m, cm, mm, in (default: inferred from the "
        "baseline)",
        metavar="UNIT",
    )


@option_group
class CalibrationOptions(CalibrationFormatOptions):
    """How a calibration file without images is read."""

    size: str | None = option("of the images, for a calibration that says none", metavar="WxH")


@option_group
class ImageOptions(CalibrationFormatOptions):
    """Images, videos and bags that lie anywhere."""

    title = "images from elsewhere, with --calibration"
    left: str | None = option("left images: a file, a folder or 'left/*.png'; or a video", metavar="FILES")
    right: str | None = option("their right images, or the right video", metavar="FILES")
    side_by_side: str | None = option("instead: images, or a video, with left and right side by side", metavar="FILES")
    bag: str | None = option("instead: a bag of ROS 1 (file) or ROS 2 (folder)", metavar="BAG")
    left_topic: str | None = option("of the bag: the left images, raw or compressed", metavar="TOPIC")
    right_topic: str | None = option("of the bag: the right images", metavar="TOPIC")
    calibration: tuple[str, ...] | None = option(
        "their calibration, in any format; two files where each camera has its own", metavar="FILE"
    )
    tolerance: float | None = option(
        "how far apart the two frames of a pair may be (default: a quarter of the time between frames; image files "
        "are paired by names, and by times in their names only if this is given)",
        metavar="SECONDS",
    )


@option_group
class PairOptions:
    """Which pairs of a recording are used."""

    title = "which pairs"
    first: int = option("number of the first pair", 0, flag="--from", metavar="N")
    stop: int | None = option("number of the pair to stop before (default: none)", flag="--to", metavar="N")
    every: int = option("every Nth pair", 1, metavar="N")
    frames: str = option("the first N of those", "all", metavar="N|all")
    limit: str | None = option(
        "of those, at most N: of N equal stretches the pair with the most texture (default: 24 of a video, a bag or "
        "more than 100 pairs, else all; monitor: all); all pairs are used jointly",
        metavar="N|all",
    )


@option_group
class RecordingOptions(ImageOptions, PairOptions):
    """The recordings that a command is about."""

    scenes: tuple[str, ...] = argument(
        "folder with left and right images and their calibration, in any layout that is known (documentation, page "
        f"Your data): {_LAYOUTS}",
        (),
        metavar="SCENE",
    )


@option_group
class MatcherOptions:
    """The stereo matcher."""

    matcher: str = option("an installed stereo matcher: sad, bm, sgbm, or a plug-in's", "sad", metavar="NAME")


@option_group
class ViewOptions(MatcherOptions):
    """The matcher, and the view through which it sees the images."""

    view: str | None = option(
        "the rectified images, as sr.view(rig, …) makes them: projection=pinhole or equirectangular, field=DEGREES "
        "across (default: a pinhole; of fisheyes and other wide lenses that show more than a pinhole can, "
        "equirectangular)",
        metavar="NAME=VALUE,…",
    )


@option_group
class ToleranceOptions:
    """What counts as better, as worse and as good."""

    distances: str | None = option(
        "in baselines, at which epipolar errors are evaluated, and at the nearest that the images show; depth at the "
        "farthest (default: 5,10,30)",
        metavar="B,B",
    )
    tolerances: str | None = option(
        "limits of the decision, such as alpha=0.001,worse_depth_points=0.5: alpha, gain_px, worse_rows_px, "
        "worse_depth_points, blind_rows_px, good_rows_px, good_surely",
        metavar="NAME=VALUE,…",
    )


@option_group
class DecisionOptions(ViewOptions, ToleranceOptions):
    """What `sr.health` takes, and `sr.recalibrate` as well."""

    prior: str | None = option(
        "how well the initial calibration is known: saved, as an earlier repair left it; default, as after a "
        "chessboard calibration of this rig; exact: every epipolar error is a drift (default: saved, if it was)",
        metavar="saved|default|exact",
    )
    motion: Literal["auto", "on", "off"] = option(
        "use of the rig's own motion between pairs for depth: auto, where times are known and at most half a second "
        "apart; on, the pairs are consecutive, whatever their times; off (default: auto)",
        "auto",
    )
    readout: float | None = option(
        "time that the cameras' rolling shutters take from the first row of an image to the last, for --motion "
        "(default: that of a scene folder's calib.json, or 0, all rows at once)",
        metavar="SECONDS",
    )


@option_group
class ReachOptions:
    """How far a search goes."""

    reach: str = option("how far the rig may have drifted", "3,0.03", metavar="DEG,FRACTION")


@option_group
class SearchOptions:
    """How a search is done."""

    scale: float | None = option("image scale of the count schedule (default: 1)", metavar="SCALE")
    budget: float | None = option(
        "of each recording or trial; one unit: one matcher run on a full-size frame (default: no limit)",
        metavar="UNITS",
    )


@option_group
class WorkerOptions:
    """Who does the work, and with which random numbers."""

    seed: int = option("same seed, same result", 0, metavar="N")
    executor: str = option(
        "serial, threads:N, processes:N or dask:ADDRESS (of the scheduler of a Dask cluster)",
        "serial",
        metavar="SPEC",
    )


@option_group
class BoardOptions:
    """The chessboard that images show."""

    board_corners: str | None = option("inner corners of the chessboard (default: 9x6)", metavar="NxM")
    square: float | None = option("side of its squares, as the calibration had it", metavar="METRES")
