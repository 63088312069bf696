"""One decision for all who ask whether a calibration is good: from what is known of a rig to what to do.

`_rule` has the rule, `_candidates` what it chooses from, `_losses` what that loses, `_tolerances` the constants, which
`docs/reference/decision.md` explains.
"""

from stereorecal._renamed import renamed
from stereorecal.decision._decision import Decision as Decision, Verdict as Verdict
from stereorecal.decision._losses import (
    chance_of_harm as chance_of_harm,
    with_nearest_distance as with_nearest_distance,
)
from stereorecal.decision._rule import (
    decide as decide,
    decide_for_trial as decide_for_trial,
    decide_together as decide_together,
    fewer_parameters_suffice as fewer_parameters_suffice,
)
from stereorecal.decision._tolerances import (
    DEFAULT as DEFAULT,
    LIMITS as LIMITS,
    Tolerances as Tolerances,
    as_tolerances as as_tolerances,
)

__getattr__ = renamed(__name__, {"better_on_average": "decide_for_trial, whose second result it is"})
