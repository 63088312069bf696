"""The field's own table: methods x judged cases, with truth and harm as columns."""

from stereorecal.comparison.field._field import compare_field as compare_field, planned as planned
from stereorecal.comparison.field._field_result import Field as Field
from stereorecal.comparison.field._field_trial import FAILED as FAILED, FieldTrial as FieldTrial, as_trial as as_trial
from stereorecal.comparison.field._methods import (
    ACCEPTED as ACCEPTED,
    GOOD as GOOD,
    REFUSED as REFUSED,
    AbstractMethod as AbstractMethod,
    Answer as Answer,
    Library as Library,
    Strategy as Strategy,
    methods_of as methods_of,
)
