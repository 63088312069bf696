"""The assessment of the initial rig: one look at the images through it, matched, estimated and decided as a stage
does, without a search."""

from dataclasses import dataclass, replace

import numpy as np

from stereorecal.decision import Verdict
from stereorecal.recalibration._acceptance import LEAST_COVERED
from stereorecal.recalibration._case import Case
from stereorecal.recalibration._ending import Ending
from stereorecal.recalibration._estimate_and_decide import Answer, ended_by, estimate_and_decide
from stereorecal.recalibration._schedule import ScoreKind, Stage
from stereorecal.recalibration._stages import FEWEST, StageRun, matched


@dataclass(frozen=True, eq=False)
class InitialAssessment:
    """One look at the images through a calibration, without any search.

    Attributes:
        run: what was done, as a stage of a schedule.
        answer: of its correspondences; None if there are too few, or they cover too little.
    """

    run: StageRun
    answer: Answer | None

    @property
    def run_at_no_cost(self) -> StageRun:
        """What was done, without its cost: no budget pays for a look, which `Cost.starts` holds."""
        return replace(self.run, matching_cost=0.0)

    @property
    def cost(self) -> float:
        """Units that it took."""
        return self.run.cost

    def ending(self, case: Case) -> Ending:
        """The candidate, and the verdict on it; only with an answer."""
        assert self.answer is not None
        return ended_by(case, self.answer)

    @property
    def repairs(self) -> bool:
        """Whether it is sure of a repair that leaves no rows misaligned: where a rig is so far off that rows are not
        searched there, a look sees what fits by chance."""
        return self.verdict is Verdict.REPAIR and self.answer is not None and self.answer.decision.is_understood

    @property
    def explains(self) -> bool:
        """Whether its repair leaves nothing to intrinsics."""
        return self.repairs and self.answer is not None and self.answer.decision.explains

    @property
    def row_error(self) -> float:
        """The row error of its candidate over the view [px], median; infinite without an answer."""
        return np.inf if self.answer is None else float(self.answer.decision.rows_px[1, 0])

    @property
    def covered(self) -> float:
        """By correspondences, share of the frame that shows most."""
        return 0.0 if self.run.found is None else self.run.found.covered

    @property
    def verdict(self) -> Verdict | None:
        """On the calibration; None if too little is seen for one."""
        answer = self.answer
        conclusive = answer is not None and answer.enough and not answer.frames_disagree and not answer.sparse
        return answer.decision.verdict if answer is not None and conclusive else None


def assess_initial_rig(case: Case, stage: Stage) -> InitialAssessment | None:
    """Look at the images as a stage does; None if it has no correspondences.

    Args:
        case: with a disparity range.
    """
    if stage.score is not ScoreKind.EPIPOLAR:
        return None
    data, chart = case.images.at(case.scale_of(stage), stage.frames), case.of_extrinsics.chart
    found = matched(data, chart, np.zeros(chart.dim), case.matcher)
    run = StageRun(stage, case.scale_of(stage), case.rig, case.rig, (), np.zeros((0, 7)), data.cost, found)
    few = found.found < FEWEST or found.covered < LEAST_COVERED
    return InitialAssessment(run, None if few else estimate_and_decide(case, run, case.rig, corners=False))
