"""The field's own table: methods x judged cases, with truth and harm as columns."""

from stereorecal_field.table._field import compare_field as compare_field, planned as planned
from stereorecal_field.table._field_result import Field as Field
from stereorecal_field.table._field_tables import field_tables as field_tables
from stereorecal_field.table._field_trial import FAILED as FAILED, FieldTrial as FieldTrial, as_trial as as_trial
from stereorecal_field.table._methods import (
    ACCEPTED as ACCEPTED,
    GOOD as GOOD,
    REFUSED as REFUSED,
    AbstractMethod as AbstractMethod,
    Answer as Answer,
    Library as Library,
    Strategy as Strategy,
    methods_of as methods_of,
)
