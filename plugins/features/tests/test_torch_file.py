"""Tensors are read as torch wrote them, and a pickle that asks for anything else is refused, unrun."""

import io
import pickle
import zipfile
from collections import OrderedDict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from stereorecal_features._torch_file import read_tensors


class _Named:
    """Pickles as a call of a function of this name, which need not be installed."""

    def __init__(self, name: str, *arguments):
        self.name, self.arguments = name, arguments


class _Pickler(pickle._Pickler):  # pyright: ignore[reportAttributeAccessIssue]
    """Writes what torch.save writes; the one in C cannot name what is not there."""

    def save(self, obj, save_persistent_id=True):
        if isinstance(obj, _Named):
            self.write(f"c{obj.name}\n".encode())
            if obj.arguments:
                self.save(obj.arguments)
                self.write(pickle.REDUCE)
            return
        super().save(obj, save_persistent_id)

    def persistent_id(self, obj):
        return tuple(obj) if isinstance(obj, list) else None


def tensor(key: str, shape, strides, offset: int = 0, kind: str = "FloatStorage"):
    storage = ["storage", _Named(f"torch\n{kind}"), key, "cpu", 0]
    return _Named("torch._utils\n_rebuild_tensor_v2", storage, offset, shape, strides, False, OrderedDict())


def written(folder: Path, content, **members: bytes) -> Path:
    pickled = io.BytesIO()
    _Pickler(pickled, 2).dump(content)
    return archived(folder, pickled.getvalue(), **members)


def archived(folder: Path, pickled: bytes, **members: bytes) -> Path:
    file = folder / "weights.pt"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("any/data.pkl", pickled)
        for key, content in members.items():
            archive.writestr(f"any/data/{key}", content)
    return file


def test_tensors_come_back(tmp_path):
    numbers = np.arange(12, dtype="<f4")
    content = OrderedDict(
        whole=tensor("a", (3, 4), (4, 1)),
        turned=tensor("a", (4, 2), (1, 4), 4),
        count=tensor("n", (), (), 0, "LongStorage"),
    )
    found = read_tensors(written(tmp_path, content, a=numbers.tobytes(), n=np.array([7], "<i8").tobytes()))
    np.testing.assert_array_equal(found["whole"], numbers.reshape(3, 4))
    np.testing.assert_array_equal(found["turned"], numbers.reshape(3, 4)[1:].T)
    assert found["count"] == 7
    assert found["whole"].flags.writeable


def test_as_torch_reads_them(tmp_path):
    torch = pytest.importorskip("torch", reason="torch, the oracle, is not installed")
    whole = torch.arange(24.0).reshape(2, 3, 4)
    state = OrderedDict(whole=whole, part=whole.permute(2, 0, 1)[1:], half=whole.half(), one=torch.tensor(3))
    torch.save(state, tmp_path / "state.pt")
    found = read_tensors(tmp_path / "state.pt")
    assert list(found) == list(state)
    for name, values in state.items():
        np.testing.assert_array_equal(found[name], values.numpy())


@pytest.mark.parametrize(
    "name", ["os\nsystem", "builtins\neval", "builtins\ngetattr", "torch\nload", "numpy\nload", "collections\nCounter"]
)
def test_a_malicious_pickle_is_refused_and_not_run(tmp_path, name):
    evil = tmp_path / "evil"
    content = OrderedDict(weight=_Named(name, f"touch {evil}"))
    with pytest.raises(ValueError, match="which is no tensor; not read"):
        read_tensors(written(tmp_path, content))
    assert not evil.exists()


def test_names_with_dots_and_attributes_lead_nowhere(tmp_path):
    for pickled in (
        b"\x80\x04\x8c\x0bcollections\x8c\x14OrderedDict.__init__\x93.",  # STACK_GLOBAL
        b"\x80\x02ccollections\nOrderedDict\n}U\x08__init__U\x01xsb.",  # BUILD on the class itself
        b"cposix\nsystem\n(S'true'\ntR.",
    ):
        with pytest.raises(ValueError):  # noqa: PT011
            read_tensors(archived(tmp_path, pickled))
    assert OrderedDict(a=1) == {"a": 1}


@pytest.mark.parametrize(
    ("shape", "strides", "offset"),
    [
        ((4, 4), (4, 1), 0),
        ((12,), (1,), 1),
        ((2,), (-1,), 3),
        ((2,), (100,), 0),
        ((1,), (1,), -1),
        ((1 << 20, 1 << 20), (0, 0), 0),
        ((13,), (0,), 0),  # 13 copies of a number: it is no part of 12
        ((2,), (1,), 0.5),
        ((2.0,), (1,), 0),
        ((True,), (1,), 0),
    ],
)
def test_a_tensor_stays_within_its_numbers(tmp_path, shape, strides, offset):
    content = OrderedDict(weight=tensor("a", shape, strides, offset))
    with pytest.raises(ValueError, match="reaches beyond its numbers"):
        read_tensors(written(tmp_path, content, a=np.zeros(12, "<f4").tobytes()))


def test_a_tensor_is_made_of_a_storage_only(tmp_path):
    """A tensor of a tensor has strides of its own, beside which the check of the numbers says nothing."""
    spread = tensor("a", (4, 3), (1, 4))
    for storage in (spread, "words", (0.0,) * 12):
        nested = _Named("torch._utils\n_rebuild_tensor_v2", storage, 1, (1,), (1,), False, OrderedDict())
        with pytest.raises(ValueError, match="not of a storage"):
            read_tensors(written(tmp_path, OrderedDict(weight=nested), a=np.zeros(12, "<f4").tobytes()))


@pytest.mark.parametrize("kind", ["words", "<c16", "O", 3, (4, 4)])
def test_a_storage_has_a_known_type(tmp_path, kind):
    content = _Named("torch._utils\n_rebuild_tensor_v2", ["storage", kind, "a", "cpu", 0], 0, (1,), (1,))
    with pytest.raises(ValueError, match="names a storage that is none"):
        read_tensors(written(tmp_path, OrderedDict(weight=content), a=np.zeros(16, "<f8").tobytes()))


@pytest.mark.parametrize("content", [[1, 2], {"weight": 3.0}, _Named("collections\nOrderedDict", ["a", 1])])
def test_anything_but_tensors_by_name_is_refused(tmp_path, content):
    with pytest.raises(ValueError, match=r"tensor"):
        read_tensors(written(tmp_path, content))


def test_no_archive_and_no_file(tmp_path):
    (tmp_path / "a.pt").write_bytes(b"\x80\x02}q\x00.")
    with pytest.raises(ValueError, match="not a file of tensors"):
        read_tensors(tmp_path / "a.pt")
    with pytest.raises(FileNotFoundError):
        read_tensors(tmp_path / "b.pt")


@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 10_000), byte=st.integers(0, 255), end=st.integers(0, 10_000))
def test_damage_is_a_sentence_or_harmless(tmp_path_factory, place, byte, end):
    """Whatever happens to the pickle: tensors, or ValueError."""
    folder = tmp_path_factory.mktemp("damaged")
    pickled = io.BytesIO()
    _Pickler(pickled, 2).dump(OrderedDict(weight=tensor("a", (3,), (1,)), bias=tensor("a", (2,), (1,), 1)))
    content = bytearray(pickled.getvalue())
    content[place % len(content)] = byte
    file = archived(folder, bytes(content[: len(content) - end % 3]), a=np.zeros(3, "<f4").tobytes())
    try:
        found = read_tensors(file)
    except ValueError:
        return
    assert all(isinstance(values, np.ndarray) for values in found.values())
