"""YAML as text: read, and changed number by number, with libyaml and without it."""

import pytest
import yaml
from hypothesis import given, strategies as st
from parts_of_repairs import Syntax, _yaml, document, plain

from stereorecal import InputError


def parsed(text):
    return plain(_yaml.tree(text)[1])


def with_values(text, values):
    return document("a text", text, Syntax.YAML).with_values(values)


LOADERS = [_yaml._Loader, yaml.SafeLoader]


@pytest.fixture(params=LOADERS, ids=["usual", "pure Python"])
def loader(request, monkeypatch):
    monkeypatch.setattr(_yaml, "_Loader", request.param)


@pytest.mark.usefixtures("loader")
@pytest.mark.parametrize(
    "head",
    [
        "",
        "%YAML:1.0\n---\n",
        "%YAML 1.0\n---\n",
        "%YAML 1.2\n---\n",
        "\ufeff",
        "\ufeff\ufeff%YAML:1.0\n",
        "# käse ü€ \U0001f600\n",
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_only_the_number_changes(head, end):
    text = f'{head}b: "ö"\na: [12, 3.5]\nm: !!opencv-matrix\n   data: [ 1., 2. ]\nc: 2\n'.replace("\n", end)
    after = with_values(text, {("a",): [7.5, 3.5, 1.0], ("m", "data"): [1.0, 4.0]})
    assert after == text.replace("12, 3.5", "7.5, 3.5, 1.0").replace("1., 2. ]", "1., 4.0 ]")
    assert parsed(after) == {"b": "ö", "a": [7.5, 3.5, 1.0], "m": {"data": [1.0, 4.0]}, "c": 2}


@pytest.mark.usefixtures("loader")
@pytest.mark.parametrize("text", ["a: [1,\n b: ", "a: \ud800", "a: \x00", "[" * 5_000, "- 1", ""])
def test_what_is_no_yaml_is_refused(text):
    with pytest.raises(InputError, match="not a YAML file"):
        parsed(text)


@pytest.mark.usefixtures("loader")
def test_what_cannot_be_told_apart_is_refused():
    with pytest.raises(InputError, match="the key 'R' occurs twice"):
        parsed("R: [1.0]\nT: 2\nR: [3.0]\n")
    with pytest.raises(InputError, match="several YAML documents"):
        parsed("a: 1\n---\nb: 2\n")
    assert parsed("a: 1\n---\na: 2\n") == {"documents": [{"a": 1}, {"a": 2}]}  # echoed messages
    for end in ("---\n", "---\n---\n", "---\n...\n"):  # as `ros2 topic echo` ends
        assert parsed(f"a: 1\n{end}") == {"a": 1}
    assert parsed("a: 1\na: 1\nb: x\nb: y\n") == {"a": 1, "b": "y"}  # the same, or words


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=5), st.text("aö€\U0001f600 ", max_size=8))
def test_both_change_the_same(values, word):
    text, after = f"# {word}\nw: '{word}'\na: {[0.0] * len(values)}\n", []
    for one in LOADERS:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(_yaml, "_Loader", one)
            after.append(with_values(text, {("a",): values}))
    assert after[0] == after[1]
