"""The options of `python -m stereorecal reproduce`. Nothing here imports JAX, OpenCV or NumPy."""

from importlib import import_module
from pathlib import Path
from typing import Literal

from stereorecal import InputError
from stereorecal.cli import (
    READS,
    SEARCH,
    WRITES,
    MatcherOptions,
    ReachOptions,
    ReportOptions,
    WorkerOptions,
    argument,
    existing_folder,
    number_or_all,
    option,
    option_group,
)


@option_group
class ReproduceOptions(ReportOptions, ReachOptions, MatcherOptions, WorkerOptions):
    """Run the paper's experiments on a log of missions: is the count highest under the right calibration (validity);
    repair from a wrong one (repair); does a repair on one pair hold for the others (generalise); repair from the
    baseline alone (ex-nihilo); repair pair after pair (sequential). Without a log, one is rendered. An interrupted run
    continues where it stopped."""

    summary = "run the paper's experiments"
    module = "stereorecal_paper._command"

    forms = ("[EXPERIMENT …]",)
    output: str | None = option(WRITES, "folder for tables and figures (default: reproduced/LOG)", metavar="DIR")
    experiments: tuple[str, ...] = argument(
        READS, "validity, repair, generalise, ex-nihilo, sequential, all (default: all)", ("all",), metavar="EXPERIMENT"
    )
    log: str | None = option(READS, "folder of missions (layouts: page Your data)", metavar="DIR")
    frames: str | None = option(
        READS, "first pairs of each sequence of --log (default: 10)", metavar="N|all", reads=number_or_all
    )
    quick: bool = option(READS, "a small log, few pairs: does everything work?", False)
    schedule: Literal["both", "default", "count"] = option(
        SEARCH, "count (the paper's way), default (coarse to fine), or both (default: both)", "both", metavar="NAME"
    )
    strategy: str | None = option(
        SEARCH, "in place of compass, or of the fit between matches if it needs residuals", metavar="NAME"
    )

    def check(self) -> None:
        if self.log is not None:
            existing_folder(self.log)
        if self.output == "-":
            raise InputError("--output -: the results are files in a folder; give the name of one.")
        if self.output is not None and Path(self.output).exists() and not Path(self.output).is_dir():
            raise InputError(f"--output {self.output}: this is a file; give the name of a folder.")
        super().check()
        if self.strategy is not None:
            import_module("stereorecal.strategies").check_installed(self.strategy)
