"""What would other tolerances decide? The decision on estimates that benchmarks recorded; prints one table.

    python tests/benchmarks/decisions.py … --record FOLDER        (likewise truth.py and misfit.py)
    python tests/benchmarks/replay.py FOLDER [--with NAME=VALUE,NAME=VALUE] …

Nothing is searched, matched or estimated: `decide` and the checks, with the default tolerances, and with others. What
images show beside is that of the recorded candidate. Harmful, missed, good: as in truth.py; in brackets, harm counts
from 0.02 px on.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from recorded import ROWS_CHANGED, Case, recorded
from tables import command_line, show, table_of

from stereorecal.decision import DEFAULT, Reason, Tolerances, as_tolerances, decide, reason_of


@dataclass(frozen=True)
class Outcome:
    """The outcome of one case under one rule."""

    accepted: bool
    harmful: bool
    changed: bool
    missed: bool
    healthy: bool


def outcome(case: Case, tolerances: Tolerances) -> Outcome:
    """Decide, and judge what would be used."""
    before = after = case.judge(case.start)
    reason = Reason.NO_MATCHES
    if case.estimate is not None and case.seen is not None:
        decision = decide(case.estimate, case.free, tolerances)
        reason = reason_of(decision, case.seen)
        after = case.judge(case.estimate.chart.rig_at(decision.theta)) if reason.accepted else before
    worse, changed = after.worse_than(before), after.worse_than(before, ROWS_CHANGED)
    missed = before.in_need and not reason.accepted
    return Outcome(reason.accepted, worse, changed, missed, reason.healthy)


def rules(given: list[str]) -> Iterator[tuple[str, Tolerances]]:
    """The default, and others, by what they are called on the command line."""
    yield "default", DEFAULT
    for text in given:
        named = dict(part.split("=") for part in text.split(","))
        yield text, as_tolerances({name: float(value) for name, value in named.items()})


def main() -> None:
    """Replay, print."""
    parser = command_line(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--with", dest="others", action="append", default=[], metavar="NAME=VALUE,…")
    options = parser.parse_args()
    several, found = list(rules(options.others)), {}
    for case in recorded(options.folder):
        for rule, tolerances in several:
            found.setdefault((case.bench, rule), []).append(outcome(case, tolerances))
    table = table_of("bench | tolerances | cases | accepted | harmful | missed | good or repaired", left=2)
    for (bench, rule), outcomes in found.items():
        accepted, harmful, changed, missed, healthy = (
            sum(getattr(one, name) for one in outcomes)
            for name in ("accepted", "harmful", "changed", "missed", "healthy")
        )
        numbers = (len(outcomes), accepted, f"{harmful} ({changed})", missed, healthy)
        table.add_row(bench, rule, *map(str, numbers))
    show(table)


if __name__ == "__main__":
    main()
