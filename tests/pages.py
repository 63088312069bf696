"""Pages as a program reads them."""

import re
from html.parser import HTMLParser

_VOID = {"meta", "br", "link", "img", "hr", "input"}


class Reader(HTMLParser):
    """Elements in order with their attributes, what they hold as text by name, and those that are not closed."""

    def __init__(self, page: str):
        super().__init__()
        self.opened: list[str] = []
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: dict[str, list[str]] = {}
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))
        if tag not in _VOID:
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
        """The attributes of each element of that name."""
        return [attributes for name, attributes in self.elements if name == tag]

    def heads(self, level: int) -> list[str]:
        return [text.strip() for text in self.texts.get(f"h{level}", [])]


def assert_whole_and_alone(page: str) -> None:
    """Well formed, every name in it once, and nothing asked of others."""
    read = Reader(page)
    assert page.startswith("<!DOCTYPE html>")
    assert read.opened == []
    ids = [attributes["id"] for _, attributes in read.elements if attributes.get("id")]
    assert len(ids) == len(set(ids))
    assert not {"link", "iframe", "object", "base"} & {tag for tag, _ in read.elements}
    for _, attributes in read.elements:
        for name in ("src", "href", "xlink:href", "srcset", "action", "data"):
            value = attributes.get(name)
            assert value is None or value.startswith(("data:image/", "#")), value
    assert not re.search(r"url\((?!#)|@import", page)
