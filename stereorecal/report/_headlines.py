"""What to do after a repair, and where depth cannot be trusted, in sentences."""

from stereorecal.report._regions import in_short, unseen, where_not
from stereorecal.report.repair_report import RepairReport, Verdict

_NOT_MEASURED = (
    "Rows were not measured, only matches counted: that tells neither where in the image depth can be trusted, nor how "
    "far."
)


def headline(report: RepairReport) -> str:
    """What to do, in one sentence."""
    if report.verdict is Verdict.UNKNOWN:
        return "Cannot tell whether the calibration is right; it stays as it is"
    if report.verdict is Verdict.REFUSED:
        return "Not repaired: the calibration stays as it is, and its depth cannot be trusted"
    repaired = report.verdict is Verdict.REPAIRED
    best = "Use the new calibration" if repaired else "Keep the calibration that you have"
    place = None if report.misfit is None else in_short(report.misfit, report.when)
    if place is None:
        return best if repaired else f"{best}: it is good"
    return f"{best}, but do not trust depth {place}"


def where(report: RepairReport) -> list[str]:
    """Where rows lie apart under the calibration to use, and, where a candidate was refused, under that."""
    if report.misfit is None:
        return [_NOT_MEASURED] if report.verdict in (Verdict.REPAIRED, Verdict.GOOD) else []
    said = [where_not(report.misfit, report.when, "" if report.accepted else "With the calibration that you keep")]
    if report.verdict is Verdict.REFUSED:
        said.append(
            where_not(report.misfit, "after", "With the candidate, which was not taken", "it does not fit there")
        )
    return [*said, *filter(None, [unseen(report.misfit)])]
