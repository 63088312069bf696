"""What to show next, in words."""

import pytest
from parts_of_repairs import away, next_step, reason, undetermined

from stereorecal.online import Advice, Showing, Undetermined

ROWS = Undetermined("epipolar", 10.0, 0.612, 0.3)
DEPTH = Undetermined("depth", 30, 7.1, 5.0)
NEAR = Showing(ROWS, 0.25, (2, 0), 5.0, motion=False)


def advised(show: Showing | None = None, *missing: Undetermined, blind: bool = False, stands: bool = False) -> Advice:
    return Advice(missing, ("yaw",) if missing else (), show, blind, stands)


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (advised(NEAR, ROWS), "show something within 85 cm, in the lower left of the view"),
        (
            advised(Showing(ROWS, 0.1, (1, 1), 30.0, False)),
            "show something 2.1 to 6.6 m away, in the middle of the view",
        ),
        (
            advised(Showing(ROWS, 0.1, (0, 1), 300.0, False)),
            "show something farther than 6.6 m, at the top of the view",
        ),
        (advised(Showing(DEPTH, 2.0, None, None, True)), "drive on: depth needs motion"),
        (advised(Showing(DEPTH, 2.0, None, 5.0, True)), "drive on past something within 85 cm: depth needs motion"),
        (advised(Showing(ROWS, 0.1, None, None, True)), "drive on"),
        (advised(NEAR, ROWS, blind=True), "turn the rig towards something with texture, in good light"),
        (advised(None, DEPTH, ROWS), "nothing to be seen here would tell more of depth"),
        (advised(), "go on"),
        (advised(stands=True), "nothing: the answer stands"),
    ],
)
def test_one_sentence(found: Advice, text: str):
    assert next_step(found, 0.12).startswith(text)


def test_what_it_narrows():
    assert reason(advised(NEAR, ROWS), 0.12) == "epipolar error at 1.2 m: ± 0.61 px now, ± 0.25 px then"
    depth = Showing(DEPTH, 2.0, None, None, True)
    assert reason(advised(depth, DEPTH), 0.12) == "depth at 3.6 m: ± 26 cm now, ± 72 mm then"
    assert reason(advised(), 0.12) == reason(advised(NEAR, ROWS, blind=True), 0.12) == ""


def test_what_is_not_determined():
    more = Undetermined("epipolar", 5.0, 0.4, 0.3)
    text = undetermined(advised(None, ROWS, DEPTH, more), 0.12)
    assert text == "epipolar error at 60 cm, 1.2 m (± 0.61 px); depth at 3.6 m (± 26 cm); axes yaw"
    assert undetermined(advised(), 0.12) == "nothing"


def test_distances_that_count_as_one():
    assert [away(one, 0.12) for one in (5.0, 10.0, 30.0, 100.0)] == [
        "within 85 cm",
        "85 cm to 2.1 m away",
        "2.1 to 6.6 m away",
        "farther than 6.6 m",
    ]
