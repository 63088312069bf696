"""The pages in a real browser: no complaint, nothing cut, a slider that moves, light and dark, printed."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from browser import Page, browser_path, chromium
from made_up_repair import made_up

from stereorecal.comparison import compare_scenes
from stereorecal.matching import SAD
from stereorecal.report.repair_page import repair_page
from stereorecal.report.repair_report import Change, Conclusion
from stereorecal.strategies import Budget, strategy

pytestmark = pytest.mark.skipif(browser_path() is None, reason="there is no Chromium on this machine")
AFTER = "getComputedStyle(document.querySelector('#rows .stack > div + div')).opacity"


@pytest.fixture(scope="module")
def browser(tmp_path_factory) -> Iterator[Page]:
    with chromium(tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture(scope="module")
def files(scene, tmp_path_factory) -> dict[str, Path]:
    """The page of a repair, and that of a comparison with long names."""
    folder = tmp_path_factory.mktemp("pages")
    places = {name: folder / f"{name}.html" for name in ("repair", "comparison")}
    places["repair"].write_text(repair_page(made_up()), encoding="utf-8")
    chosen = {"compass": strategy("compass"), "a-name-that-is-very-long-" * 3: strategy("compass", step=0.1)}
    small = {"matcher": SAD(num_disparities=24), "draws": 2, "scale": 0.5, "budget": Budget(evaluations=60)}
    compare_scenes([scene()], strategies=chosen, **small).to_html(places["comparison"])
    return places


def opened(browser: Page, path: Path) -> Page:
    """A page, 1200 pixels wide."""
    browser.complaints.clear()
    browser.requests.clear()
    browser.look(1200)
    browser.open(path)
    return browser


@pytest.fixture
def repair(browser: Page, files: dict[str, Path]) -> Page:
    return opened(browser, files["repair"])


@pytest.fixture(params=["repair", "comparison"])
def page(browser: Page, files: dict[str, Path], request: pytest.FixtureRequest) -> Page:
    return opened(browser, files[request.param])


def test_no_complaint_and_nothing_asked_of_others(page: Page):
    assert page.complaints == []
    assert all(url.startswith(("file:///", "data:")) for url in page.requests)
    assert sum(url.startswith("file:") for url in page.requests) == 1
    assert page.evaluate("[...document.images].every(image => image.complete && image.naturalWidth > 0)")
    assert page.evaluate("[...document.images].every(image => image.alt.length > 0)")
    labelled = "[...document.querySelectorAll('svg')].every(e => e.getAttribute('aria-label') || e.ariaHidden)"
    assert page.evaluate(labelled)


def test_no_label_is_cut(page: Page):
    """Each word of a figure lies within it."""
    cut = """[...document.querySelectorAll('svg')].flatMap(svg => {
        const whole = svg.getBoundingClientRect();
        return [...svg.querySelectorAll('text')].filter(text => {
            const box = text.getBoundingClientRect();
            return box.left < whole.left - 1 || box.right > whole.right + 1;
        }).map(text => text.textContent);
    })"""
    assert page.evaluate(cut) == []


def test_a_wide_table_scrolls_by_keyboard(browser: Page, files: dict[str, Path]):
    page = opened(browser, files["comparison"])
    page.look(400)
    page.press("Tab", 9)
    box = "document.activeElement"
    assert page.evaluate(f"{box}.className + ': ' + {box}.ariaLabel") == "wide: Summary, a wide table"
    assert page.evaluate(f"{box}.scrollWidth > {box}.clientWidth")
    page.press("ArrowRight", 39)
    scrolled = f"""new Promise(done => {{
        const end = performance.now() + 10000;  // the browser scrolls smoothly
        const ended = () => {box}.scrollLeft > 0 || performance.now() > end;
        const look = () => ended() ? done({box}.scrollLeft) : setTimeout(look, 20);
        look();
    }})"""
    assert page.evaluate(scrolled) > 0


def test_slider_by_keyboard(repair: Page):
    """It says what it shows."""
    said = "document.querySelector('input[type=range]').getAttribute('aria-valuetext')"
    assert float(repair.evaluate(AFTER)) == 1.0
    assert repair.evaluate(said) == "0 % before, 100 % after"
    repair.evaluate("document.querySelector('input[type=range]').focus()")
    repair.press("Home", 36)
    assert float(repair.evaluate(AFTER)) == 0.0
    assert repair.evaluate(said) == "100 % before, 0 % after"
    repair.press("ArrowRight", 39)
    assert float(repair.evaluate(AFTER)) == pytest.approx(0.01)


def test_slider_of_the_disparity(repair: Page):
    """It wipes: the picture before and the one after lie on each other, and each half is of one of them."""
    place = "document.querySelector('#disparity .stack')"
    repair.evaluate(f"{place}.scrollIntoView()")
    corner = "[b.x + scrollX, b.y + scrollY, b.width, b.height]"
    box = repair.evaluate(f"(b => {corner})({place}.getBoundingClientRect())")
    pictures = {}
    for share in (0, 50, 100):
        change = f"e.value = {share}; e.dispatchEvent(new Event('input'))"
        repair.evaluate(f"(() => {{ const e = document.querySelector('#disparity input'); {change}; }})()")
        pictures[share] = repair.seen(*box)
    middle = pictures[0].shape[1] // 2
    assert not np.array_equal(pictures[0], pictures[100])
    assert np.array_equal(pictures[50][:, : middle - 2], pictures[100][:, : middle - 2])
    assert np.array_equal(pictures[50][:, middle + 2 :], pictures[0][:, middle + 2 :])


@pytest.mark.parametrize("width", [400, 1200])
def test_figures_are_read(page: Page, width: int):
    """On a telephone too, no letter is smaller than 9 pixels."""
    page.look(width)
    sizes = """[...document.querySelectorAll('svg text')].map(text => {
        const across = text.getScreenCTM();
        return Math.hypot(across.a, across.b) * parseFloat(getComputedStyle(text).fontSize);
    })"""
    assert min(page.evaluate(sizes)) >= 9.0


def test_changes_of_axes_fit_a_telephone(browser: Page, tmp_path: Path):
    """With their intervals, beside a candidate too."""
    axes = [
        Change("yaw", "°", -0.44, -0.176, 0.288, True),
        Change("x", "mm", -356.0, 0.0, None, True),
        Change("z", "mm", -3.6, 8.877, 20.556, False),
    ]
    path = tmp_path / "out.html"
    path.write_text(repair_page(made_up(conclusion=Conclusion.GOOD, axes=axes)), encoding="utf-8")
    page = opened(browser, path)
    page.look(400)
    box = "document.querySelector('[aria-label=Axes]')"
    assert page.evaluate(f"{box}.scrollWidth <= {box}.clientWidth")


def test_wide_tables_scroll_by_keyboard(repair: Page):
    repair.look(320)
    repair.evaluate("document.querySelectorAll('details').forEach(part => part.open = true)")
    assert repair.evaluate("document.documentElement.scrollWidth <= innerWidth")
    unreached = "[...document.querySelectorAll('*')].filter(e => e.scrollWidth > e.clientWidth + 1 && e.tabIndex < 0"
    shown = "&& /auto|scroll/.test(getComputedStyle(e).overflowX)).map(e => e.outerHTML.slice(0, 80))"
    assert repair.evaluate(unreached + shown) == []


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
def test_it_fits(page: Page, width: int, scheme: str):
    page.look(width, scheme=scheme)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    picture = cv2.imdecode(np.frombuffer(page.picture(), np.uint8), cv2.IMREAD_GRAYSCALE)
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
    aside = "[...document.querySelectorAll('#disparity .stack > div')].map(e => [e.offsetLeft, e.offsetTop])"
    (left, top), (right, level) = repair.evaluate(aside)
    assert right > left
    assert top == level
    assert repair.evaluate("getComputedStyle(document.querySelector('.slider')).display") == "none"
    assert repair.pdf().startswith(b"%PDF")
