"""Options stand once: what callers may say, what a repair computes with, and what the descriptions name."""

import stereorecal as sr
from stereorecal.recalibration import as_settings

OPTIONS = sr.RepairOptions.__optional_keys__


def test_nothing_said_is_the_default():
    found = as_settings({})
    assert found == as_settings(dict.fromkeys(OPTIONS - {"seed", "ranges"}))
    assert (found.seed, found.ranges, found.matcher) == (0, (), sr.SAD())
    assert (found.reach, found.budget, found.free) == (sr.Reach(), sr.Budget(), sr.Parameters(everything=True))
    assert found.schedule == sr.Schedule.default()


def test_ranges_free_the_length_of_the_baseline():
    named = sr.Range("pair", (5.0, 5.0), 3.0)
    assert as_settings({"ranges": named}).free.names == (*sr.Parameters().names, "baseline")
