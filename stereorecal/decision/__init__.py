"""One decision for all who ask whether a calibration is good: from what is known of a rig to what to do.

`_decision` has the rule and its constants; `docs/estimate.md` explains them.
"""

from stereorecal.decision._decision import (
    LIMITS as LIMITS,
    Decision as Decision,
    Verdict as Verdict,
    decide as decide,
    decide_together as decide_together,
    do_as_well as do_as_well,
)
