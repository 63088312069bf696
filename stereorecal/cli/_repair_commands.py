"""The options of the commands that repair a rig, check it and watch it."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from stereorecal._errors import InputError
from stereorecal.cli._option_values import camera_names, parameter_names, schedule_name
from stereorecal.cli._options import (
    DEPTH,
    READS,
    RIG,
    RUNNING,
    SEARCH,
    TWO_FILES,
    WRITES,
    CommonOptions,
    option,
    option_group,
)
from stereorecal.cli._places import calibration_path, check_places
from stereorecal.cli._shared_options import (
    FREE,
    ExecutorOptions,
    HealthOptions,
    JudgingOptions,
    ReachOptions,
    RecordingOptions,
    ReportOptions,
    folders_of,
)


@option_group
class OutputOptions(CommonOptions):
    """Where the repaired calibration goes, and a recording of the run."""

    output: str | None = option(
        WRITES,
        "the calibration, if it was repaired: a copy of the file that was read, with the new values (LEFT,RIGHT if "
        "each camera has a file)",
        metavar="FILE",
        reads=calibration_path,
        writes=True,
    )
    rrd: str | None = option(
        WRITES, "a recording with pictures, for Rerun's viewer (rerun FILE)", metavar="FILE", writes=True
    )


@option_group
class RepairFileOptions(ReportOptions):
    """What else a repair writes."""

    maps: str | None = option(
        WRITES,
        "maps for cv2.remap, and R1 R2 P1 P2 Q: of the repaired calibration, or of the initial one if that is good",
        metavar="FILE.npz",
        writes=True,
    )
    html: str | None = option(WRITES, "one page with pictures", metavar="FILE", writes=True)
    force: bool = option(
        WRITES,
        "replace existing files; of those that are read only the calibration, by --output, which keeps it as NAME.bak",
        False,
    )


@option_group
class RecalibrateOptions(OutputOptions, RepairFileOptions, HealthOptions, ReachOptions, ExecutorOptions):
    """Repair the calibration of each recording's rig from its images. Recordings with the same intrinsics are of one
    rig, unless the images show another: each gets its own extrinsics, and all share what is found of the intrinsics. A
    candidate is accepted only if it gains, if it makes rows or depth worse with less than 2 % probability, and if it
    predicts parts that were left out.

    Exit code: 0 repaired, or already good; 1 not (the initial calibration stays); 2 bad input, also images that are
    certainly exchanged, upside down or of different scenes; 3 internal failure; 4 cannot tell (too dark, too little
    texture, or the images do not determine what is better); 5 wrong input (these cannot be images of this rig:
    exchanged, of two moments, another size); 130 interrupted. Of several recordings, the worst one decides."""

    summary = "repair the calibration of a rig"
    module = "stereorecal.cli._recalibrate"

    free: str | None = option(
        RIG, f"{FREE} (default: all that the calibration file can hold)", metavar="NAME,…", reads=parameter_names
    )
    ranges: str | None = option(
        DEPTH,
        "CSV of distances: pair,column,row,metres,sigma (along the ray), or with depth for metres (along the axis)",
        metavar="FILE",
        loads="stereorecal.io:load_ranges",
    )
    odometer: str | None = option(
        DEPTH,
        "CSV of the distance travelled, in the time of the pairs: time_s,metres or time_s,speed_mps or time_s,x,y,z; "
        "gaps above 1.1 s are not used",
        metavar="FILE",
        loads="stereorecal.io:load_odometer",
    )
    schedule: str = option(
        SEARCH,
        "default (coarse to fine) or count (the paper's way); with a strategy for the stages of its kind: "
        "count:nlopt-bobyqa",
        "default",
        metavar="NAME[:STRATEGY]",
        reads=schedule_name,
    )

    def known_of(self, rigs: Sequence[Any]) -> Any:
        """The prior of the recordings with these rigs; another distribution may know more of them."""
        return self.prior

    def check(self) -> None:
        super().check()
        if any(len(folders_of(scene)) > 1 for scene in self.scenes):
            alone = {"--motion on": self.motion == "on", "--odometer": self.odometer}
            alone["--fix"] = self.fix in ("late", "early")
            if found := [name for name, given in alone.items() if given]:
                raise InputError(f"{found[0]} takes the pairs of one folder; leave it out, or give no A+B.")
        if self.fix in ("exchanged", "turned") and self.ranges:
            raise InputError(f"--fix {self.fix} changes images alone; with --ranges, change the files.")
        named = [f"--{name}" for name in ("output", "maps", "html", "rrd") if getattr(self, name) is not None]
        if named and len(self.scenes) > 1:
            hint = f" ({TWO_FILES})" if self.output is not None else ""
            raise InputError(
                f"{named[0]} takes one recording; run the command once for each, or join folders of a rig that stayed "
                f"as it was: A+B{hint}."
            )
        if self.maps is not None and Path(self.maps).suffix.lower() not in ("", ".npz"):
            raise InputError(f"--maps {self.maps}: maps are written as .npz; give a name ending in it.")


@option_group
class ScoreOptions(HealthOptions):
    """Check the calibration of each recording against its images, and change nothing. The report says what a repair by
    one look at them would: the share of matched pixels, and, where they tell, the epipolar error and the error of depth
    with 95 % intervals.

    Exit code, by the verdict: 0 good (no significant improvement, and an epipolar error within 0.3 px with 95 %
    probability); 1 repair it (another calibration is a significant improvement, or hardly anything matches, and the rig
    turned); 4 cannot tell (too dark, too little texture, or no improvement is significant); 5 wrong input (these cannot
    be images of this rig: exchanged, of two moments, another size). Others: 2 bad input, also images that are certainly
    exchanged, upside down or of different scenes; 3 internal failure; 130 interrupted."""

    summary = "check a calibration against images"
    module = "stereorecal.cli._score"


@option_group
class MonitorOptions(OutputOptions, ReportOptions, RecordingOptions, JudgingOptions):
    """Watch a rig pair by pair, over a recording or while its cameras run: its health over time, knocks, drift, late
    shutters. Repair it. Say what to show it next. A terminal shows a live view, other outputs get lines. The
    calibration file stays as it is.

    Exit code, for the calibration in use at the end: 0 healthy; 1 repair it; 2 bad input; 3 internal failure; 4 cannot
    tell, or with --until-sure not yet; 130 interrupted."""

    summary = "watch a rig over a recording, and repair it"
    module = "stereorecal.cli._monitor"

    forms = ("SCENE", "--left L --right R --calibration FILE", "--camera NAME --calibration FILE")
    show: bool = option(WRITES, "open the pictures in Rerun's viewer", False)
    json: str | None = option(
        WRITES,
        "events and readings, as JSON lines; appended if --state continues a watch",
        metavar="FILE|-",
        writes=True,
    )
    state: str | None = option(
        WRITES, "the state of the watch; a file that exists is continued", metavar="FILE", writes=True
    )
    camera: tuple[str, ...] | None = option(
        READS,
        "running cameras, instead of a recording: numbers (0,1), devices, addresses or GStreamer pipelines (two "
        "words); or one that shows both images side by side",
        metavar="NAME",
        reads=camera_names,
    )
    synchronous: bool = option(READS, "a trigger opens both shutters at once: no delay is estimated", False)
    once: bool = option(RUNNING, "only watch, and switch nothing: a check of the calibration, for cron", False)
    until_sure: bool = option(
        RUNNING,
        "end once the verdict stands, and epipolar errors and depth are known as well as matters (a service goes on)",
        False,
    )

    @property
    def goes_on(self) -> bool:
        """Whether a watch is continued."""
        return self.state is not None and Path(self.state).exists()

    def check(self) -> None:
        if self.camera is None:
            self.check_recordings()
        going_on = ("--state", "--json") if self.goes_on else ("--state",)
        check_places([place for place in self.places if place.option not in going_on], force=self.force)
        check_places(self.places, force=True)
