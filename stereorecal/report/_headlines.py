"""The headline of a repair, and sentences on where depth cannot be trusted."""

from stereorecal.report._regions import coverage_sentence, misfit_sentence, short_place
from stereorecal.report.repair_report import Conclusion, RepairReport

_NOT_MEASURED = (
    "Epipolar errors were not measured, only matches counted: it is not known where in the image depth can be trusted."
)


def headline(report: RepairReport) -> str:
    """What to do, in one sentence."""
    if report.conclusion is Conclusion.UNKNOWN:
        return "Cannot tell whether the calibration is right; it stays as it is"
    if report.conclusion is Conclusion.REFUSED:
        return "Not repaired: the calibration stays as it is, and its depth cannot be trusted"
    repaired = report.conclusion is Conclusion.REPAIRED
    best = "Use the new calibration" if repaired else "Keep the calibration that you have"
    place = None if report.misfit is None else short_place(report.misfit, report.when)
    if place is None:
        return best if repaired else f"{best}: it is good"
    return f"{best}, but do not trust depth {place}"


def where(report: RepairReport) -> list[str]:
    """Where the epipolar error is too large: of the calibration to use, and of a candidate that was refused."""
    if report.misfit is None:
        return [_NOT_MEASURED] if report.conclusion in (Conclusion.REPAIRED, Conclusion.GOOD) else []
    sentences = [
        misfit_sentence(report.misfit, report.when, "" if report.accepted else "With the calibration that you keep")
    ]
    if report.conclusion is Conclusion.REFUSED:
        sentences.append(
            misfit_sentence(report.misfit, "after", "With the candidate, which was rejected", "it does not fit there")
        )
    return [*sentences, *filter(None, [coverage_sentence(report.misfit)])]
