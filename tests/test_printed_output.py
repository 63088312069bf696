"""How what pages show is compared with what their code prints."""

import pytest
from printed_output import agrees

PRINTED = """accepted: better
search   met its rule (92 evaluations, 6.1 s)
before   44 005 of 307 200 pixels (14.3 %)
roll      -0.065 ->    +0.269 deg
depth -4.0 % at 5 B; -8.0 % at 10 B; -21.0 % at 30 B
[ 0.01 -0.   -0.  ] degrees
"""


@pytest.mark.parametrize(
    "shown",
    [
        PRINTED,
        PRINTED.replace("6.1 s", "0.4 s"),
        PRINTED.replace("44 005", "44 905").replace("14.3", "14.4"),
        PRINTED.replace("[ 0.01 -0.   -0.  ]", "[0.01 0. 0.02]"),
        "accepted: better\n…\nroll -0.065 -> +0.268 deg\n…",
        "accepted: …\n[0. 0. 0.] degrees",
        "…\ndepth …; -21.0 % at 30 B\n…",
        "…",
    ],
)
def test_it_is_shown_truly(shown: str):
    assert agrees(shown, PRINTED)


@pytest.mark.parametrize(
    "shown",
    [
        "",
        "accepted: better",  # and more, which is left out silently
        "accepted: worse\n…",
        "…\nroll -0.065 -> -0.269 deg\n…",
        "…\nroll -0.065 -> +0.369 deg\n…",
        "…\nbefore 54 005 of 307 200 pixels …",
        "…\nroll …\nsearch …",
        "…\ndepth …; -8.0 % at 30 B\n…",
        PRINTED.replace("92 evaluations", "107 evaluations"),
        PRINTED.replace("5 B", "6 B"),
    ],
)
def test_it_is_not(shown: str):
    assert not agrees(shown, PRINTED)
