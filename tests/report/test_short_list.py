"""Lists that a reader can take in at a glance."""

from hypothesis import given, strategies as st

from stereorecal.report.number_text import MOST, short_list


@given(st.lists(st.text("abcdef", min_size=1), max_size=30))
def test_nothing_is_lost_but_counted(names: list[str]):
    said = short_list(names, "; ").split("; ") if names else []
    assert len(said) == min(len(names), MOST)
    shown = [*said] if len(names) <= MOST else said[:-1]
    assert shown == names[: len(shown)]
    if len(names) > MOST:
        assert said[-1] == f"{len(names) - len(shown)} more"
