"""Files damaged as discs, networks and programs damage them, and as nobody would think of."""

import re

import numpy as np

_NUMBERS = (
    b"nan",
    b"inf",
    b"-1",
    b"0",
    b"1e300",
    b"1e-300",
    b"1e999",
    b"9" * 400,
    b"1_0",
    b"0x10",
    b"true",
    b"null",
    b"'1'",
    b"[]",
    b"{}",
    b"1048577",
    b"20000",
)
_DEEP = (b"[", b"{", b'{"a":', b"- ", b"<a>", b"!!a ", b"&a [", b"? ", b"  ")


def damaged(data: bytes, random: np.random.Generator) -> bytes:
    """The bytes with one to three kinds of damage."""
    for _ in range(random.integers(1, 4)):
        data = _DAMAGES[random.integers(len(_DAMAGES))](data, random)
    return data


def _flip(data: bytes, random: np.random.Generator) -> bytes:
    changed = bytearray(data)
    for _ in range(random.integers(1, 9) if changed else 0):
        changed[random.integers(len(changed))] ^= 1 << random.integers(8)
    return bytes(changed)


def _cut(data: bytes, random: np.random.Generator) -> bytes:
    return data[: random.integers(len(data) + 1)]


def _cut_out(data: bytes, random: np.random.Generator) -> bytes:
    start, stop = _stretch(data, random)
    return data[:start] + data[stop:]


def _repeat(data: bytes, random: np.random.Generator) -> bytes:
    start, stop = _stretch(data, random)
    return data[:start] + data[start:stop] * int(random.integers(2, 200)) + data[stop:]


def _fill(data: bytes, random: np.random.Generator) -> bytes:
    start, stop = _stretch(data, random)
    return data[:start] + bytes([random.integers(256)]) * (stop - start) + data[stop:]


def _exchange(data: bytes, random: np.random.Generator) -> bytes:
    start, stop = _stretch(data, random)
    middle = (start + stop) // 2
    return data[:start] + data[middle:stop] + data[start:middle] + data[stop:]


def _number(data: bytes, random: np.random.Generator) -> bytes:
    """Another value in place of a number."""
    found = list(re.finditer(rb"[-+]?\d[\d.eE+-]*", data[:20_000]))
    if not found:
        return _fill(data, random)
    chosen = found[random.integers(len(found))]
    return data[: chosen.start()] + _NUMBERS[random.integers(len(_NUMBERS))] + data[chosen.end() :]


def _line(data: bytes, random: np.random.Generator) -> bytes:
    """A line is lost or comes twice."""
    lines = data.split(b"\n")
    index = random.integers(len(lines))
    return b"\n".join(lines[:index] + [lines[index]] * int(random.choice([0, 2])) + lines[index + 1 :])


def _deep(data: bytes, random: np.random.Generator) -> bytes:
    """Nested deeper and deeper."""
    place = random.integers(len(data) + 1)
    opening = _DEEP[random.integers(len(_DEEP))]
    return data[:place] + opening * int(random.choice([50, 500, 5000, 200_000])) + data[place:]


def _stretch(data: bytes, random: np.random.Generator) -> tuple[int, int]:
    start = int(random.integers(len(data) + 1))
    return start, min(len(data), start + int(random.geometric(0.02)))


_DAMAGES = (_flip, _cut, _cut_out, _repeat, _fill, _exchange, _number, _number, _line, _deep)
