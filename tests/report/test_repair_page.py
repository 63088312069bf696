"""The page of a repair: whole, self-contained, escaped, with words for every picture."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest
from made_up_repair import EVIL, made_up, sight

from stereorecal.report.repair_page import repair_page

VOID = {"meta", "img", "input", "br"}


class Reader(HTMLParser):
    """Elements with their attributes, and whether each is closed."""

    def __init__(self, page: str):
        super().__init__()
        self.opened: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.opened.append(tag)
            self.texts.setdefault(tag, []).append("")

    def handle_startendtag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.opened.pop() == tag

    def handle_data(self, data):
        for tag in set(self.opened):
            self.texts[tag][-1] += data

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.elements if name == tag]


@pytest.fixture(scope="module")
def page() -> str:
    return repair_page(made_up())


def test_it_is_well_formed_and_has_every_part(page: str):
    read = Reader(page)
    assert read.opened == []
    assert page.startswith("<!DOCTYPE html>")
    assert [text.strip() for text in read.texts["h2"]] == [
        "One rectified pair",
        "Disparity",
        "Which axis moved, and by how much",
        "Refined intrinsics",
        "Rows that lie apart",
        "Errors of depth",
        "The search",
        "Frames",
        "To run it again",
    ]


def test_it_needs_nothing_from_outside(page: str):
    read = Reader(page)
    assert not {"link", "iframe", "object", "base"} & {tag for tag, _ in read.elements}
    for _, attributes in read.elements:
        for name in ("src", "href", "xlink:href", "srcset", "action", "data"):
            value = attributes.get(name)
            assert value is None or value.startswith(("data:image/", "#")), value
    assert not re.search(r"url\((?!#)|@import", page)
    (policy,) = [a["content"] for a in read.all("meta") if a.get("http-equiv") == "Content-Security-Policy"]
    assert policy is not None
    assert policy.startswith("default-src 'none'")


def test_every_picture_has_words(page: str):
    read = Reader(page)
    assert len(read.all("img")) == 4
    assert all((a.get("alt") or "").endswith(".") for a in read.all("img"))
    assert len(read.all("svg")) == 6
    assert all(a.get("role") == "img" and a.get("aria-label") for a in read.all("svg"))
    (slider,) = read.all("input")
    assert slider["aria-label"]


def test_names_are_escaped(page: str):
    assert EVIL not in page
    assert len(Reader(page).all("script")) == 1
    ids = [a["id"] for _, a in Reader(page).elements if a.get("id")]
    assert len(ids) == len(set(ids))


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("size", [(160, 120), (1800, 1350), (1200, 2000)], ids=str)
def test_it_can_be_mailed(size):
    assert len(repair_page(made_up(size)).encode()) < 3_000_000


def test_without_rows_it_is_shorter():
    read = Reader(repair_page(made_up(measured=False, climbs=[])))
    assert read.opened == []
    assert "Rows that lie apart" not in read.texts["h2"]
    assert read.all("svg") == []


@pytest.mark.slow
def test_nothing_matched():
    nothing = sight((160, 120), 0)
    empty = type(nothing)(nothing.left, nothing.right, nothing.disparity, np.zeros_like(nothing.valid))
    assert "0 % of the pixels" in repair_page(made_up(before=empty, after=empty))
