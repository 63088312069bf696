"""The HTML page of a comparison: whole, self-contained, escaped, light."""

import json
import re
from dataclasses import asdict, dataclass, replace

import numpy as np
import pytest
from pages import Reader, assert_whole_and_alone

from stereorecal.comparison import Comparison, compare_scenes
from stereorecal.io import json_data
from stereorecal.matching import SAD
from stereorecal.report.comparison_page import comparison_page
from stereorecal.strategies import AbstractStrategy, Budget, strategy

EVIL = "<script>alert('x')</script>"


@dataclass(frozen=True)
class Crashing(AbstractStrategy):
    def run(self, objective, start, seed):
        raise KeyError(EVIL)


@pytest.fixture(scope="module")
def table(scene) -> Comparison:
    chosen = {"compass": strategy("compass"), EVIL: strategy("compass", step=0.1), "crashing": Crashing()}
    scenes = [replace(scene(), name="data/<b>harbour</b>")]
    small = {"matcher": SAD(num_disparities=24), "draws": 2, "scale": 0.5, "budget": Budget(evaluations=100)}
    return compare_scenes(scenes, strategies=chosen, **small)


@pytest.fixture(scope="module")
def page(table: Comparison) -> str:
    return comparison_page(table.as_dict())


def test_it_is_whole_and_alone_and_has_every_part(page: str):
    assert_whole_and_alone(page)
    read = Reader(page)
    assert read.all("script") == []
    assert len(read.all("svg")) == 2
    assert read.heads(2) == [
        "Summary",
        "Skipped or failed",
        "Trials by strategy",
        "Terms",
    ]
    assert [text.strip() for text in read.texts["summary"]] == ["6 trials", "Scenes", "Settings and versions"]


def test_it_serves_dark_pages_and_keyboards(page: str):
    """Figures take the colours of the page, and wide tables are reached."""
    assert "#010203" not in page
    assert "fill: currentColor" in page
    assert "prefers-color-scheme: dark" in page
    boxes = re.findall(r'<div class="wide"[^>]*>|<pre[^>]*>', page)
    assert len(boxes) == 5
    assert all('tabindex="0" role="region" aria-label="' in box for box in boxes)


def test_foreign_text_is_text(table: Comparison, page: str):
    """Nor is it a formula in a figure."""
    assert EVIL not in page
    assert "<b>harbour" not in page
    read = Reader(page)
    assert EVIL in read.texts["td"]
    assert any(EVIL in item for item in read.texts["li"])
    assert "data/<b>harbour</b>" in read.texts["h3"]
    formula = tuple(replace(trial, strategy="a$b_{$c", strategies=("a$b_{$c",)) for trial in table.trials)
    drawn = Reader(comparison_page(replace(table, trials=formula).as_dict())).texts["text"]
    assert any("a$b_{$c" in text for text in drawn)


def test_numbers_are_those_of_the_comparison(table: Comparison, page: str):
    text = Reader(page).texts
    for trial in (trial for trial in table.trials if trial.ratio is not None):
        for number in (f"{trial.ratio:.3f}", f"{trial.rotation_error_deg['yaw']:.3f}"):
            assert number in text["td"]
    assert "the true rig" in text["dd"]
    assert any("within 0.05°" in entry for entry in text["dd"])
    assert json.loads(text["pre"][0])["versions"] == table.versions


def test_schedules_side_by_side(table: Comparison):
    """Each schedule has its rows, its strip in each figure and its meaning."""
    ran = {"default": ("compass", "solver"), "count": ("compass",)}
    trials = tuple(
        replace(trial, strategy="compass", schedule=schedule, strategies=names)
        for schedule, names in ran.items()
        for trial in table.trials
        if trial.strategy == "compass"
    )
    entrants = [{"strategy": "compass", "schedule": name, "strategies": list(ran[name])} for name in ran]
    settings = {**table.settings, "strategies": ["compass"], "entrants": entrants, "schedule": "count and default"}
    read = Reader(comparison_page(replace(table, trials=trials, settings=settings).as_dict()))
    assert [text.strip() for text in read.texts["h1"]] == ["2 schedules on 1 scene"]
    assert "schedules default and count" in " ".join(read.texts["p"])
    assert "Trials by schedule" in read.heads(2)
    assert {"compass + solver", "default", "count"} <= set(read.texts["td"])
    assert {"schedule default", "schedule count"} <= set(read.texts["dt"])
    drawn = " ".join(read.texts["text"])
    assert "default" in drawn
    assert "count" in drawn


def test_a_ratio_above_the_limit_is_flagged(table: Comparison, page: str):
    high = [replace(trial, ratio=1.051) if trial.ratio else trial for trial in table.trials]
    assert "!</td>" not in page
    flagged = comparison_page(replace(table, trials=tuple(high)).as_dict())
    assert flagged.count("<td>1.051!</td>") == 4 + 2  # trials, and medians


def test_interrupted_or_empty(table: Comparison):
    cut = replace(table, trials=table.trials[:1], interrupted=True)
    said = " ".join(Reader(comparison_page(cut.as_dict())).texts["p"])
    assert "Interrupted: 1 trial was finished of 6." in said
    empty = Reader(comparison_page(replace(cut, trials=()).as_dict()))
    assert "0 trials were finished of 6." in " ".join(empty.texts["p"])
    assert empty.all("svg") == []
    assert empty.opened == []


@pytest.mark.slow
def test_a_thousand_trials_are_a_small_page(table: Comparison):
    trials = tuple(replace(trial, draw=draw) for draw in range(350) for trial in table.trials[:3])
    few = comparison_page(replace(table, trials=trials[:90]).as_dict())
    many = comparison_page(replace(table, trials=trials).as_dict())
    assert len(many) < 700_000
    drawings = [re.sub(r"<details>.*", "", page, flags=re.DOTALL) for page in (few, many)]
    assert len(drawings[1]) < len(drawings[0])


def test_to_html_writes_the_page(table: Comparison, page: str, tmp_path):
    target = tmp_path / "out.html"
    target.write_text("old")
    table.to_html(target)
    written = target.read_text(encoding="utf-8")
    assert list(tmp_path.iterdir()) == [target]
    read = Reader(written)
    assert read.opened == []
    assert {"Over the units spent", "What trials look like"} <= set(read.heads(2))
    assert len(read.all("svg")) == len(Reader(page).all("svg")) + 3
    pictures = [image["src"] for image in read.all("img")]
    assert len(pictures) == 2 * 3 + 1  # before and after, and the colour bar
    said = " ".join(read.texts["p"])
    assert re.search(r"far, \d+ px\d+ px, near; black: none", said)
    assert all(value and value.startswith("data:image/jpeg;") for value in pictures)
    assert all(image["alt"] for image in read.all("img"))
    assert EVIL not in written


def test_pictures_are_ranked_as_the_table_is(table: Comparison, tmp_path):
    """A wrong calibration that out-scores the right one is not the best trial."""
    first, second = (trial for trial in table.trials if trial.strategy == "compass")
    near, far = dict.fromkeys(("pitch", "yaw", "roll"), 0.01), dict.fromkeys(("pitch", "yaw", "roll"), 0.5)
    wrong, right = (
        replace(first, ratio=1.2, rotation_error_deg=far),
        replace(second, ratio=0.99, rotation_error_deg=near),
    )
    replace(table, trials=(wrong, right)).to_html(tmp_path / "out.html")
    written = (tmp_path / "out.html").read_text(encoding="utf-8")
    best = f"best: compass, schedule count, draw {right.draw}, r = 0.990, a success"
    worst = f"worst: compass, schedule count, draw {wrong.draw}, r = 1.200, no success"
    assert 0 < written.find(best) < written.find(worst)


def test_data_profiles(table: Comparison):
    """The share of solved trials rises with the cost; a strategy that crashed has no curve."""
    profile = table.data_profile()
    assert [curve.strategy for curve in profile] == ["compass", EVIL]
    for curve in profile:
        assert np.all(np.diff(curve.share) >= 0.0)
        assert curve.cost[0] == 0.0
        assert np.all(np.diff(curve.rotation_error_deg, axis=0) >= 0.0)  # quartiles in order
        assert curve.score is not None
        assert np.all(np.diff(curve.score[1]) >= 0.0)


def test_curves_of_a_strategy_that_spends_nothing(table: Comparison):
    """As one that works on the images: it is level from the start at what it ended with, over a range that can be seen;
    and the page says so."""
    course = {"score": [10.0, 30.0], "rotation_error_deg": [0.4, 0.1], "axes_deg": [[0.4, 0.0, 0.0], [0.1, 0.0, 0.0]]}
    trial = replace(table.trials[0], cost=0.0, course={"cost": [0.0, 0.0], **course})
    comparison = replace(table, trials=(trial,))
    [curve] = comparison.data_profile()
    assert (curve.cost[0], curve.cost[-1]) == (0.0, 1.0)
    assert curve.score is not None
    assert np.all(curve.score == 30.0)
    page = comparison_page(comparison.as_dict(), [json_data(asdict(curve))])
    assert any("compass, no units spent" in entry for entry in Reader(page).texts["text"])
    assert "level where its trials have ended" in " ".join(Reader(page).texts["p"])


def test_when_a_trial_is_solved(table: Comparison):

    def solved_at(axes_deg, accepted: bool) -> float:
        """The cost from which on the profile of a trial of so many steps counts it as solved."""
        nothing = [0.0] * len(axes_deg)
        course = {"cost": [*range(len(nothing))], "score": nothing, "rotation_error_deg": nothing, "axes_deg": axes_deg}
        trial = replace(table.trials[0], course=course, cost=course["cost"][-1], accepted=accepted)
        (profile,) = replace(table, trials=(trial,)).data_profile()
        return float(profile.cost[profile.share > 0.0].min(initial=np.inf))

    far, near = [1.0, 0.0, 0.0], [0.01, 0.1, 0.01]
    assert solved_at([far, near, far, near], accepted=True) == 3.0
    assert solved_at([far, near, far, near], accepted=False) == np.inf
    assert solved_at([near, near], accepted=False) == 0.0
    assert solved_at([near, far], accepted=False) == 0.0  # it stays where it began
    assert solved_at([near, far], accepted=True) == np.inf
