"""Warmed up, neither a repair nor a step on the vehicle compiles anything, whatever the images show."""

import jax
import numpy as np
import pytest

import stereorecal as sr
from stereorecal.matching import SAD

SIZE = (168, 120)  # of no other test: nothing of it is compiled before
FAR = np.radians([-1.5, 1.0, 2.0, 0.0, 0.0, 0.0])


@pytest.mark.slow
@pytest.mark.skipif(jax.default_backend() != "cpu", reason="a GPU's batches depend on the number of frames")
def test_nothing_is_left_to_compile(scene, caplog):
    two = scene("street", 0, SIZE, 2)
    matcher = SAD(num_disparities=32)
    with jax.log_compiles(), caplog.at_level("WARNING"):
        sr.warm_up(two.rig, matcher=matcher)
    assert _compiled(caplog) != []  # positive control: there was something to compile, and it would have been seen
    caplog.clear()
    bad = sr.synthetic.decalibrate(two.rig, jax.random.key(1), 1.0, 0.01)
    with jax.log_compiles(), caplog.at_level("WARNING"):
        sr.recalibrate(bad, two.pairs[:1], matcher=matcher)
        sr.recalibrate(bad, two.pairs, matcher=matcher)
        for rig in (two.rig, two.rig.with_extrinsics(two.rig.extrinsics + FAR)):
            watched = list(sr.online.run(rig, [*two.pairs, *two.pairs], sr.online.Config(matcher=matcher)))
    assert any(event.kind is sr.online.Kind.REPAIRING for stepped in watched for event in stepped.events)
    assert _compiled(caplog) == []


def _compiled(caplog) -> list[str]:
    return [record.message for record in caplog.records if "ompil" in record.message]


def test_a_range_that_is_never_measured():
    with pytest.raises(sr.InputError, match="disparities 70 is not one of the measured ranges; choose from"):
        sr.warm_up(sr.synthetic.default_rig(), disparities=(64, 70))
