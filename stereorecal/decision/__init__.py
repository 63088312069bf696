"""One decision for all who ask whether a calibration is good: from what is known of a rig to what to do.

`_rule` has the rule, `_checks` what images must show besides, `_tolerances` the numbers of both, which
`docs/reference/decision.md` explains.
"""

from stereorecal.decision._checks import (
    CHECKS as CHECKS,
    Check as Check,
    Reason as Reason,
    Seen as Seen,
    is_sparse as is_sparse,
    reason_of as reason_of,
)
from stereorecal.decision._rule import (
    Criterion as Criterion,
    Decision as Decision,
    Verdict as Verdict,
    decide as decide,
    decide_together as decide_together,
)
from stereorecal.decision._tolerances import (
    DEFAULT as DEFAULT,
    ENOUGH as ENOUGH,
    LIMITS as LIMITS,
    Enough as Enough,
    Tolerances as Tolerances,
    as_tolerances as as_tolerances,
)
