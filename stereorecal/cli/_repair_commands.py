"""The options of the commands that repair a rig, check it and watch it."""

from stereorecal.cli._options import CommonOptions, option, option_group
from stereorecal.cli._shared_options import (
    FORMATS,
    FREE,
    BoardOptions,
    DecisionOptions,
    ReachOptions,
    RecordingOptions,
    ReportOptions,
    SearchOptions,
    ToleranceOptions,
    ViewOptions,
    WorkerOptions,
)


@option_group
class RecalibrateOptions(
    RecordingOptions,
    DecisionOptions,
    ReachOptions,
    SearchOptions,
    BoardOptions,
    WorkerOptions,
    ReportOptions,
    CommonOptions,
):
    """Repair the extrinsic calibration of the rig of each recording from its images. The candidate is accepted only if
    its row error is smaller with 99 % probability, and a larger row or depth error has a probability below 1 %. Exit
    code: 0 repaired, or already good; 1 not (the initial calibration stays); 2 bad input; 3 internal failure; 4 cannot
    tell (too dark, too little texture, or the images do not determine what is better); 130 interrupted. Of several
    recordings, the worst one decides."""

    output: str | None = option(
        "write the calibration there (LEFT,RIGHT where each camera has a file), if it was accepted: in the form in "
        "which it was read, only what was estimated changes",
        metavar="FILE",
    )
    output_format: str | None = option(f"of --output, if another: {FORMATS}", metavar="FORMAT")
    in_place: bool = option("replace the calibration that was read; the old one becomes NAME.bak", False)
    maps: str | None = option(
        "write maps for cv2.remap, with R1 R2 P1 P2 Q, of the repaired calibration, or of the initial one if that is "
        "already good",
        metavar="FILE.npz",
    )
    dry_run: bool = option("write no calibration and no maps, say what would be written", False)
    html: str | None = option("write one HTML page with pictures, to look at and to pass on", metavar="FILE")
    schedule: str = option(
        "default (coarse to fine, which is used if nothing is said) or count (the paper's way)",
        "default",
        metavar="NAME",
    )
    strategy: str | None = option("for the stages of its kind (default: those of the schedule)", metavar="NAME")
    free: str | None = option(
        f"{FREE} (default: extrinsics; of one recording, or with --extrinsics one, all else too, where four places "
        "prove that it must)",
        metavar="NAME,…",
    )
    extrinsics: str = option(
        "of several recordings of one rig: each has extrinsics of its own, or one set is that of all, of a rig that "
        "did not drift between them",
        "each",
        metavar="each|one",
    )
    boards: tuple[str, str] | None = option(
        "images of the chessboard that the initial calibration was made from, left and right: each a file, a folder "
        "or 'left/*.png'; needs --square",
        metavar=("LEFT", "RIGHT"),
    )
    odometer: str | None = option(
        "a CSV of how far the rig travelled, of the clock of the pairs: time_s,metres or time_s,speed_mps or "
        "time_s,x,y,z (metres, to 5 cm); nothing is made of gaps of more than 1.1 s",
        metavar="FILE",
    )
    ranges: str | None = option(
        "a CSV of distances: pair,column,row,metres,sigma (along the ray; depth for metres: the axis)", metavar="FILE"
    )


@option_group
class ScoreOptions(RecordingOptions, DecisionOptions, ReportOptions, CommonOptions):
    """Check the calibration of each recording against its images, without changing anything: the share of matched
    pixels, the epipolar (row) error, the correction of the rotation, and the depth error without it, with 95 %
    intervals. Verdicts: repair it (another calibration has a row error smaller by 0.05 px with 99 % probability, and a
    larger row or depth error with less than 1 %; or hardly anything matches although there is texture); healthy (no
    significant improvement, and a row error within 0.3 px with 95 %); cannot tell (too dark, too little texture, or no
    improvement is significant). `recalibrate` decides in the same way. Exit code: 0 all healthy; 1 repair it (one of
    them at least); 2 bad input, also images that are swapped, upside down or of different scenes; 3 internal failure; 4
    cannot tell; 130 interrupted."""


@option_group
class MonitorOptions(RecordingOptions, ViewOptions, ToleranceOptions, ReportOptions, CommonOptions):
    """Watch a rig over a recording, or while its cameras run, pair by pair: its health fused over time, knocks, drift,
    late shutters; repair it, and switch to what wins on later pairs. A terminal shows a live view; else events are
    lines. The calibration file stays as it is: a repaired one is written where --output says. Exit code: that of score,
    for the calibration in use at the end: 0 healthy; 1 repair it; 2 bad input; 3 internal failure; 4 cannot tell; 130
    interrupted."""

    camera: tuple[str, ...] | None = option(
        "watch cameras while they run, in place of a recording, with --calibration: numbers (0,1), devices, addresses, "
        "or GStreamer pipelines (two words); one that shows both images side by side; --tolerance as above",
        metavar="NAME",
    )
    synchronous: bool = option(
        "a trigger opens both shutters at once: no delay between them is taken into account", False
    )
    once: bool = option("watch alone, switch nothing: a check of the calibration, for cron", False)
    state: str | None = option(
        "go on from the state in this file, which is of this calibration; keep it there", metavar="FILE"
    )
    output: str | None = option(
        "write the repaired calibration there, in the form in which it was read, if there is one", metavar="FILE"
    )
    json: str | None = option(
        "write events and readings as JSON lines; append them if a --state goes on", metavar="FILE|-"
    )
    force: bool = option("--output and --json may replace files (not a log that goes on)", False)
    quiet: bool = option("show nothing, only the exit code", False)
