"""The options of the commands that compare methods, and run the paper's experiments."""

from stereorecal.cli._options import CommonOptions, argument, option, option_group
from stereorecal.cli._shared_options import (
    FREE,
    BoardOptions,
    MatcherOptions,
    ReachOptions,
    ReportOptions,
    SearchOptions,
    WorkerOptions,
)


@option_group
class CompareOptions(MatcherOptions, SearchOptions, BoardOptions, WorkerOptions, ReportOptions, CommonOptions):
    """Decalibrate the rig of each scene several times, let every strategy repair each of them, and compare. Without a
    scene, one is rendered."""

    scene: tuple[str, ...] = option("scene folder (repeatable)", (), metavar="PATH")
    synthetic: str | None = option("render a scene: harbour, coast, open-sea, street", metavar="KIND")
    frames: str | None = option(
        "pairs of each scene to use, jointly (default: 1); of judges only those of rendered and simulated, the others "
        "have pairs of their own",
        metavar="N|all",
    )
    strategies: str | None = option("names of installed strategies (default: those of the schedule)", metavar="A,B|all")
    schedule: str | None = option(
        "count (the paper's way: the count alone, at one scale) or default (coarse to fine); by default both, side by "
        "side, or count where --strategies is given",
        metavar="NAME",
    )
    decalibrate: str = option("largest drift of each axis", "0.5,0.01", metavar="DEG,FRACTION")
    reach: str | None = option(
        "half width of the search box (default: 3,0.03, or 1.2 x the drift if that is more)", metavar="DEG,FRACTION"
    )
    free: str = option(FREE, "extrinsics", metavar="NAME,…")
    draws: int | None = option(
        "decalibrations of each scene (default: 2; of --preset field 10, and 4 drives)", metavar="N"
    )
    judge: tuple[str, ...] = option(
        "compare methods by data that none of them sees (repeatable): lidar=FOLDER, boards=FOLDER, product=FOLDER, "
        "motion[=FOLDER], rendered[=KIND], simulated[=KIND], walk; only rows of lidar and of motion=FOLDER are of "
        "images that methods get, too; --strategies then names methods: the library's count, rows and motion, and "
        "strategies; --board-corners and --square are of boards=FOLDER",
        (),
        metavar="NAME[=PLACE]",
    )
    preset: str | None = option(
        "field: all judges that are rendered, and those of --judge, within an hour", metavar="NAME"
    )
    full: bool = option("of --preset field: overnight", False)
    json: str | None = option(
        "write the results as JSON, after each trial; with --judge at the end or on Ctrl-C (until then the finished "
        "trials are in FILE.trials, beside the file of --html if there is one, else of --json)",
        metavar="FILE|-",
    )
    html: str | None = option("write one HTML page with tables and figures, to pass on", metavar="FILE")


@option_group
class ReproduceOptions(MatcherOptions, ReachOptions, WorkerOptions, ReportOptions, CommonOptions):
    """Run the paper's experiments on a log of missions: is the count highest under the right calibration (validity);
    repair from a wrong one (repair); does a repair on one pair hold for the others (generalise); repair from the
    baseline alone (ex-nihilo); repair pair after pair (sequential). Without a log, one is rendered. An interrupted run
    continues where it stopped."""

    experiments: tuple[str, ...] = argument(
        "validity, repair, generalise, ex-nihilo, sequential, all (default: all)", ("all",), metavar="EXPERIMENT"
    )
    log: str | None = option("folder of missions, in any layout (documentation, page Your data)", metavar="DIR")
    frames: str | None = option("first pairs of each sequence of --log (default: 10)", metavar="N|all")
    schedule: str = option(
        "count (the paper's way), default (coarse to fine), or both (default: both)", "both", metavar="NAME"
    )
    strategy: str | None = option(
        "in place of compass, or of Levenberg-Marquardt if it needs residuals", metavar="NAME"
    )
    quick: bool = option("a small log, few pairs: does everything work?", False)
    output: str | None = option("folder for tables and figures (default: reproduced/LOG)", metavar="DIR")
