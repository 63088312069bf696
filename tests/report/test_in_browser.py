"""The pages in a real browser: no complaint, nothing cut, a slider that moves, light and dark, printed."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from browser import Page, browser_path, chromium
from made_up_repair import made_up

from stereorecal.report.repair_page import repair_page

pytestmark = pytest.mark.skipif(browser_path() is None, reason="there is no Chromium on this machine")
AFTER = "getComputedStyle(document.querySelector('#rows .stack > div + div')).opacity"


@pytest.fixture(scope="module")
def browser(tmp_path_factory) -> Iterator[Page]:
    with chromium(tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture
def repair(browser: Page, tmp_path: Path) -> Page:
    """The page of a repair, 1200 pixels wide."""
    path = tmp_path / "repair.html"
    path.write_text(repair_page(made_up()), encoding="utf-8")
    browser.complaints.clear()
    browser.requests.clear()
    browser.look(1200)
    browser.open(path)
    return browser


def test_no_complaint_and_nothing_asked_of_others(repair: Page):
    assert repair.complaints == []
    assert all(url.startswith(("file:///", "data:")) for url in repair.requests)
    assert sum(url.startswith("file:") for url in repair.requests) == 1
    assert repair.evaluate("[...document.images].every(image => image.complete && image.naturalWidth > 0)")


def test_slider_by_keyboard(repair: Page):
    assert float(repair.evaluate(AFTER)) == 1.0
    repair.evaluate("document.querySelector('input[type=range]').focus()")
    repair.press("Home", 36)
    assert float(repair.evaluate(AFTER)) == 0.0
    repair.press("ArrowRight", 39)
    assert float(repair.evaluate(AFTER)) == pytest.approx(0.01)


def test_slider_by_mouse(repair: Page):
    place = "(() => { const e = document.querySelector('input[type=range]'); e.scrollIntoView({block: 'center'});"
    box = repair.evaluate(
        f"{place} const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()"
    )
    left, top, width, height = box
    repair.drag(left + width - 8, top + height / 2, left + width / 2)
    assert float(repair.evaluate(AFTER)) == pytest.approx(0.5, abs=0.03)


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("width", [320, 768, 1200, 2000])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_fits(repair: Page, width: int, scheme: str):
    repair.look(width, scheme=scheme)
    assert repair.evaluate("document.documentElement.scrollWidth <= innerWidth")
    picture = cv2.imdecode(np.frombuffer(repair.picture(), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert picture is not None
    paper = float(np.median(picture[:, :4]))
    assert (paper > 200) == (scheme == "light")


@pytest.mark.slow
def test_printed_both_pairs_are_there(repair: Page):
    repair.look(800, medium="print")
    shown = "[...document.querySelectorAll('#rows .stack > div')].map(e => [getComputedStyle(e).opacity, e.offsetTop])"
    (first, above), (second, below) = repair.evaluate(shown)
    assert (first, second) == ("1", "1")
    assert below > above
    assert repair.evaluate("getComputedStyle(document.querySelector('.slider')).display") == "none"
    assert repair.pdf().startswith(b"%PDF")
