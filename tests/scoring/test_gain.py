"""A common gain of both images leaves the count nearly as it is."""

from dataclasses import replace

import pytest
from fixtures import SAD_48
from hypothesis import given, settings, strategies as st

from stereorecal.scoring.host import score


def under_gain(scene, gain):
    return [replace(p, left=(p.left * gain).astype("f4"), right=(p.right * gain).astype("f4")) for p in scene.pairs]


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("kind", ["harbour", "coast", "street"])
def test_common_gain(scene, kind):
    given_scene = scene(kind, 1)
    # Room above, so that nothing clips at the largest gain.
    room = 0.9
    assert max(p.left.max() for p in under_gain(given_scene, 1.1 * room)) <= 255
    reference = score(given_scene.rig, under_gain(given_scene, room), matcher=SAD_48).count

    @settings(max_examples=8)
    @given(gain=st.floats(0.7, 1.1))
    def check(gain):
        found = score(given_scene.rig, under_gain(given_scene, room * gain), matcher=SAD_48).count
        assert found == pytest.approx(reference, rel=0.03)

    check()
