"""The options of the commands that compare methods, and list and check plug-ins."""

from importlib import import_module
from typing import Literal, get_args

from stereorecal._errors import InputError, existing_folder
from stereorecal._plugins import MATCHER_NAMES
from stereorecal.cli._option_values import degrees_and_fraction, number_or_all, parameter_names, strategy_names
from stereorecal.cli._options import (
    ARGUMENTS,
    READS,
    RIG,
    SEARCH,
    WRITES,
    CommonOptions,
    argument,
    option,
    option_group,
)
from stereorecal.cli._shared_options import FREE, MatcherOptions, ReportOptions, WorkerOptions

_Kind = Literal["harbour", "coast", "open-sea", "street"]


@option_group
class CompareOptions(ReportOptions, MatcherOptions, WorkerOptions):
    """Decalibrate the rig of each scene several times, let every strategy repair each of them, and compare. Without a
    scene, one is rendered."""

    summary = "decalibrate rigs, and compare how strategies repair them"
    module = "stereorecal.cli._compare"

    json: str | None = option(WRITES, "the results, as JSON, after each trial", metavar="FILE|-", writes=True)
    html: str | None = option(WRITES, "one page with tables and figures", metavar="FILE", writes=True)
    scene: tuple[str, ...] = option(READS, "scene folder (repeatable)", (), metavar="PATH")
    synthetic: _Kind | None = option(READS, f"render a scene: {', '.join(get_args(_Kind))}", metavar="KIND")
    frames: str | None = option(
        READS, "pairs of each scene, used jointly (default: 1)", metavar="N|all", reads=number_or_all
    )
    decalibrate: str = option(
        RIG, "largest drift of each axis", "0.5,0.01", metavar="DEG,FRACTION", reads=degrees_and_fraction
    )
    draws: int | None = option(RIG, "drifts of each scene (default: 2)", metavar="N")
    reach: str | None = option(
        RIG,
        "half width of the search box (default: 3,0.03, or 1.2 x the drift if that is more)",
        metavar="DEG,FRACTION",
        reads=degrees_and_fraction,
    )
    free: str = option(RIG, FREE, "extrinsics", metavar="NAME,…", reads=parameter_names)
    strategies: str | None = option(SEARCH, "installed strategies (default: those of the schedule)", metavar="A,B|all")
    schedule: Literal["default", "count"] | None = option(
        SEARCH,
        "count (the paper's way: the count alone, at one scale) or default (coarse to fine); default: both, or count "
        "with --strategies",
        metavar="NAME",
    )
    scale: float | None = option(SEARCH, "image scale of --schedule count (default: 1)", metavar="SCALE")
    budget: float | None = option(
        SEARCH, "of each trial, in matcher runs on full-size frames (default: no limit)", metavar="UNITS"
    )

    def check(self) -> None:
        for scene in self.scene:
            existing_folder(scene)
        super().check()
        if self.strategies is not None:
            strategy_names(self.strategies)


@option_group
class PluginOptions(CommonOptions):
    """List what is installed, or run the conformance kit on one."""

    summary = "list those that are installed, or check one"
    module = "stereorecal.cli._installed_plugins"
    forms = ("[list]", "check NAME")
    action: Literal["list", "check"] = argument(
        ARGUMENTS, "list what is installed, or run the conformance kit on one", "list"
    )
    name: str | None = argument(ARGUMENTS, "the one to be checked", None, metavar="NAME")

    def __post_init__(self) -> None:
        if self.action == "check" and self.name is None:
            raise InputError(f"{self.verb} check needs a name; {self.verb} list shows those that are installed")
        if self.action == "list" and self.name is not None:
            raise InputError(f"unrecognized arguments: {self.name}")

    def check(self) -> None:
        if self.name is not None and self.verb == "strategies":
            import_module("stereorecal.strategies").check_installed(self.name)
        elif self.name is not None:
            MATCHER_NAMES.check(self.name)
