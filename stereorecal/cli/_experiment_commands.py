"""The options of the commands that compare methods, and run the paper's experiments."""

from importlib import import_module
from pathlib import Path
from typing import Literal, get_args

from stereorecal._errors import InputError
from stereorecal._existing_paths import existing_folder
from stereorecal.cli._options import CommonOptions, argument, option, option_group
from stereorecal.cli._output_places import Place, check_places, places_of
from stereorecal.cli._shared_options import (
    FREE,
    READS,
    SEARCH,
    WRITES,
    MatcherOptions,
    ReachOptions,
    ReportOptions,
    SearchOptions,
    WorkerOptions,
)

_Kind = Literal["harbour", "coast", "open-sea", "street"]


@option_group
class _ComparisonOutputOptions:
    """What a comparison writes."""

    title = WRITES
    json: str | None = option("the results, as JSON, after each trial", metavar="FILE|-")
    html: str | None = option("one page with tables and figures", metavar="FILE")


@option_group
class _ComparedSceneOptions:
    """The scenes of a comparison."""

    title = READS
    scene: tuple[str, ...] = option("scene folder (repeatable)", (), metavar="PATH")
    synthetic: _Kind | None = option(f"render a scene: {', '.join(get_args(_Kind))}", metavar="KIND")
    frames: str | None = option("pairs of each scene, used jointly (default: 1)", metavar="N|all")


@option_group
class _DriftOptions:
    """The drifts of a comparison."""

    title = "the drifts, and what may move"
    decalibrate: str = option("largest drift of each axis", "0.5,0.01", metavar="DEG,FRACTION")
    draws: int | None = option("drifts of each scene (default: 2)", metavar="N")
    reach: str | None = option(
        "half width of the search box (default: 3,0.03, or 1.2 x the drift if that is more)", metavar="DEG,FRACTION"
    )
    free: str = option(FREE, "extrinsics", metavar="NAME,…")


@option_group
class _ComparedStrategyOptions:
    """What is compared."""

    title = SEARCH
    strategies: str | None = option("installed strategies (default: those of the schedule)", metavar="A,B|all")
    schedule: Literal["default", "count"] | None = option(
        "count (the paper's way: the count alone, at one scale) or default (coarse to fine); default: both, or count "
        "with --strategies",
        metavar="NAME",
    )


@option_group
class CompareOptions(
    _ComparisonOutputOptions,
    ReportOptions,
    _ComparedSceneOptions,
    _DriftOptions,
    _ComparedStrategyOptions,
    MatcherOptions,
    SearchOptions,
    WorkerOptions,
    CommonOptions,
):
    """Decalibrate the rig of each scene several times, let every strategy repair each of them, and compare. Without a
    scene, one is rendered."""

    summary = "decalibrate rigs, and compare how strategies repair them"
    module = "stereorecal.cli._compare"

    @property
    def places(self) -> list[Place]:
        """All files that are to be written."""
        return places_of(self, "json", "html")

    def check(self) -> None:
        for scene in self.scene:
            existing_folder(scene)
        check_places(self.places, force=self.force)
        if self.strategies is not None:
            import_module("stereorecal.cli._strategy_names").strategy_names(self.strategies)


@option_group
class _ReproductionOutputOptions:
    """What the experiments write."""

    title = WRITES
    output: str | None = option("folder for tables and figures (default: reproduced/LOG)", metavar="DIR")


@option_group
class _ExperimentOptions:
    """The experiments, and their log."""

    title = READS
    experiments: tuple[str, ...] = argument(
        "validity, repair, generalise, ex-nihilo, sequential, all (default: all)", ("all",), metavar="EXPERIMENT"
    )
    log: str | None = option("folder of missions (layouts: page Your data)", metavar="DIR")
    frames: str | None = option("first pairs of each sequence of --log (default: 10)", metavar="N|all")
    quick: bool = option("a small log, few pairs: does everything work?", False)


@option_group
class _ReproducedScheduleOptions:
    """How the experiments search."""

    title = SEARCH
    schedule: Literal["both", "default", "count"] = option(
        "count (the paper's way), default (coarse to fine), or both (default: both)", "both", metavar="NAME"
    )
    strategy: str | None = option(
        "in place of compass, or of Levenberg-Marquardt if it needs residuals", metavar="NAME"
    )


@option_group
class ReproduceOptions(
    _ReproductionOutputOptions,
    ReportOptions,
    _ExperimentOptions,
    ReachOptions,
    _ReproducedScheduleOptions,
    MatcherOptions,
    WorkerOptions,
    CommonOptions,
):
    """Run the paper's experiments on a log of missions: is the count highest under the right calibration (validity);
    repair from a wrong one (repair); does a repair on one pair hold for the others (generalise); repair from the
    baseline alone (ex-nihilo); repair pair after pair (sequential). Without a log, one is rendered. An interrupted run
    continues where it stopped."""

    summary = "run the paper's experiments"
    module = "stereorecal.cli._reproduce"

    forms = ("[EXPERIMENT …]",)

    @property
    def places(self) -> list[Place]:
        """All files that are to be written, but those of the folder."""
        return places_of(self, "json")

    def check(self) -> None:
        if self.log is not None:
            existing_folder(self.log)
        if self.output == "-":
            raise InputError("--output -: the results are files in a folder; give the name of one.")
        if self.output is not None and Path(self.output).exists() and not Path(self.output).is_dir():
            raise InputError(f"--output {self.output}: this is a file; give the name of a folder.")
        check_places(self.places, force=self.force)
        if self.strategy is not None:
            import_module("stereorecal.strategies").check_installed(self.strategy)
