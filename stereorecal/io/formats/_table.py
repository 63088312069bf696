"""A format as a table: where the numbers of a rig stand in a file, and by which conventions; one reader, one writer."""

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import reduce
from typing import Any

import numpy as np
import yaml

from stereorecal._errors import InputError
from stereorecal.geometry import Camera, StereoRig
from stereorecal.io._read_files import about
from stereorecal.io._strict_json import strict_json_text
from stereorecal.io.formats._format import Cameras, Documents, Hints
from stereorecal.io.formats._numbers import (
    Array,
    check_no_lens,
    coefficients,
    has_lens,
    image_size,
    key_name,
    matrix_values,
    not_held,
    numbers,
    pinhole_matrix,
    pinhole_numbers,
    scalars,
    size_of,
    unsupported,
    value,
)
from stereorecal.io.formats._poses import Link, Motion, left_to_right, motions_from, moved, pose, rig_of, stated_pose
from stereorecal.io.formats.text._document import Syntax
from stereorecal.io.formats.text._nodes import Keys, at

Places = str | tuple[str, ...]
"""Where an array stands, or each of its numbers: keys with `/` between them, and `{}` for a camera's name."""


def places(above: str, keys: str) -> tuple[str, ...]:
    """The places of some keys, with spaces between them, below another one."""
    return tuple(f"{above}/{key}" for key in keys.split())


@dataclass(frozen=True)
class Pose:
    """How a camera stands: the motion from a body to the camera."""

    rotation: Places  # nine numbers, or four rows with the translation in them
    translation: Places = ()
    inverted: bool = False  # whether the file has the motion from the camera to the body
    between: bool = False  # whether the body is the left camera
    # Where the rotation is no matrix: the matrix of its numbers, and the numbers of a matrix.
    decode: Callable[[Array], Array] = lambda turn: turn
    encode: Callable[[Array], Array] = lambda turn: turn

    def read(self, content: Any, name: str) -> Motion:
        """The motion of the camera of a name, as the file has it."""
        with _about_place(self.rotation, name):
            if not self.translation:
                assert isinstance(self.rotation, str)
                return stated_pose(content, keys_of(content, self.rotation, name))
            turn = self.decode(stated(content, self.rotation, name, self.encode(np.eye(3)).shape))
            return pose(turn, stated(content, self.translation, name, (3,)))

    def values(self, content: Any, name: str, motion: Motion) -> dict[Keys, Any]:
        """What to write for it."""
        if not self.translation:
            return to_write(content, self.rotation, name, motion)
        turn = self.encode(motion[:3, :3])
        return to_write(content, self.rotation, name, turn) | to_write(content, self.translation, name, motion[:3, 3])

    def blank(self) -> dict[Places, Any]:
        """What new files have of a camera where the body is."""
        if not self.rotation:
            return {}
        if not self.translation:
            return {self.rotation: {"rows": 4, "cols": 4, "data": np.eye(4).ravel().tolist()}}
        return {self.rotation: self.encode(np.eye(3)).ravel().tolist(), self.translation: [0.0] * 3}


@dataclass(frozen=True)
class Lens:
    """What a file has of a lens."""

    terms: Places = ()  # the coefficients, in the order of `Camera`; with radial ones apart, the tangential two
    model: str = Camera.model  # that of `Camera`
    counts: tuple[int, ...] = (4,)  # how many coefficients of a pinhole may be written, rising
    before: int = 0  # how many coefficients stand before fx
    becomes: str = ""  # of a lens that is said to have none, the word for it once it has some
    radial: str = ""  # the place of k1 k2 k3, as many as there are, where they are a list of their own


@dataclass(frozen=True)
class Table:
    """Where the numbers of a rig stand."""

    size: Places  # (width, height)
    matrix: Places  # fx fy cx cy, or the camera matrix, if it is `square`
    lenses: Mapping[str, Lens]  # by the words that tell the lens, with spaces between them
    words: tuple[str, ...] = ()  # where they stand
    pose: Pose = Pose("")  # without a place if a table cannot say it
    square: bool = False
    names: tuple[str, str] = ("left", "right")  # of the left and the right camera, if none are chosen
    where: str = ""  # what messages about a camera begin with, if not with the first of several keys
    holder: str = ""  # whose model of a lens it is, for messages
    fixed: Mapping[str, Any] = field(default_factory=dict)  # what else a new file has, by places

    def read(self, documents: Documents, hints: Hints) -> StereoRig:
        """The rig, with T in the file's unit."""
        names, two, cameras = hints.cameras or self.names, len(documents) > 1, []
        for name, document in zip(names, (documents[0], documents[-1]), strict=True):
            with about(document.name if two else ""):
                cameras.append(self.camera(document.content, name))
        links = self._links(documents, names)
        where = " and ".join(document.name for document in documents)
        with about(where) if two else _about_place(self.pose.rotation if self.pose.between else "", ""):
            return rig_of(cameras[0], cameras[1], motions_from(names[0], links)[names[1]])

    def write(self, rig: StereoRig, documents: Documents, hints: Hints, changed: Cameras) -> list[dict[Keys, Any]]:
        """What to write: the right camera moves, the left one stays where it is."""
        names, contents = hints.cameras or self.names, [document.content for document in documents]
        found = [dict[Keys, Any]() for _ in contents]
        for link, motion in moved(self._links(documents, names), *names, left_to_right(rig)):
            found[-1] |= self.pose.values(contents[-1], link.camera, motion)
        for side, camera in changed.items():
            found[-side] |= self.values(contents[-side], names[side], camera)
        return found

    def _links(self, documents: Documents, names: tuple[str, str]) -> list[Link]:
        """How the cameras stand: both on a body, or the right one on the left one."""
        links, sides = [], [*zip(names, (documents[0], documents[-1]), strict=True)]
        for name, document in sides[1:] if self.pose.between else sides:
            with about(document.name if len(documents) > 1 else ""):
                motion = self.pose.read(document.content, name)
            links.append(Link(name, names[0] if self.pose.between else "", motion, self.pose.inverted))
        return links

    def blank(self, rig: StereoRig, syntax: Syntax) -> list[str]:
        """The texts of new files: the words and sizes of a rig, no numbers, and both cameras where the body is."""
        return [strict_json_text(one) if syntax is Syntax.JSON else yaml_text(one) for one in self.new_content(rig)]

    def new_content(self, rig: StereoRig) -> list[dict[str, Any]]:
        """The keys and values of new files."""
        found: list[dict[str, Any]] = [{}] if "{}" in "".join(self.matrix) else [{}, {}]
        for name, camera, content in zip(self.names, (rig.left, rig.right), (found[0], found[-1]), strict=True):
            said = [word for word, lens in self.lenses.items() if lens.model == camera.model]
            said = [word for word in said if self.lenses[word] != Lens() or not has_lens(rig)]
            if not said:
                raise not_held(camera, self.holder)
            lens = self.lenses[said[0]]
            new: dict[Places, Any] = {**self.fixed, **dict(zip(self.words, said[0].split(), strict=True))}
            new[self.size] = list(camera.size)
            for place, count in ((self.matrix, 9 if self.square else 4 + lens.before), (lens.terms, lens.counts[-1])):
                new[place] = [0.0] * (count if isinstance(place, str) else len(place))
            for place, item in (new | self.pose.blank()).items():
                for one, part in ((place, item),) if isinstance(place, str) else zip(place, item, strict=True):
                    *above, last = one.format(name).split("/")
                    reduce(lambda inside, key: inside.setdefault(key, {}), above, content)[last] = part
        return [_with_lists(content) for content in found]

    def lens(self, content: Any, name: str) -> Lens:
        """What the file says that a lens is."""
        said = " ".join(str(value(content, keys_of(content, place, name))) for place in self.words)
        if said not in self.lenses:
            raise unsupported(said)
        return self.lenses[said]

    def camera(self, content: Any, name: str) -> Camera:
        """The camera of a name."""
        with about(self.where.format(name)) if self.where else _about_place(self.matrix, name):
            lens = self.lens(content, name)
            found = stated(content, self.matrix, name, (3, 3) if self.square else (4 + lens.before,))
            first, matrix = (np.zeros(0), found) if self.square else np.split(found, [lens.before])
            terms = stated(content, lens.terms, name, (-1,)) if lens.terms else np.zeros(0)
            terms = _with_radial(content, lens.radial, name, terms) if lens.radial else terms
            if lens.becomes:
                check_no_lens("none", terms)
                terms = np.zeros(4) if lens.before else terms
            sizes = (self.size,) if isinstance(self.size, str) else self.size
            size = image_size(content, *(keys_of(content, place, name) for place in sizes))
            matrix = matrix if self.square else pinhole_matrix(matrix)
            return Camera(size, matrix, np.concatenate([first, terms]), model=lens.model)

    def values(self, content: Any, name: str, camera: Camera) -> dict[Keys, Any]:
        """What to write for a camera."""
        lens, terms = self.lens(content, name), np.asarray(camera.distortion, float)
        if camera.model != lens.model:
            raise not_held(camera, self.holder)
        if lens.model == Camera.model:
            counts = lens.counts if isinstance(lens.terms, str) or lens.radial else (len(lens.terms),)
            terms = coefficients(camera, counts, self.holder, "opencv, ros or depthai")
        first, terms = np.split(terms, [lens.before])
        matrix = np.asarray(camera.matrix).ravel() if self.square else pinhole_numbers(camera)
        found = to_write(content, self.matrix, name, np.array([*first, *matrix]))
        if lens.becomes and not np.any(terms):
            return found
        if lens.radial:
            found |= _radial_values(content, lens.radial, name, terms[[0, 1, 4]])
            terms = terms[2:4]
        found |= {keys_of(content, self.words[-1], name): lens.becomes} if lens.becomes else {}
        return found | (to_write(content, lens.terms, name, terms) if lens.terms else {})


def _with_radial(content: Any, place: str, name: str, tangential: Array) -> Array:
    """The coefficients in OpenCV's order; without a third radial one, four."""
    keys = keys_of(content, place, name)
    radial = numbers(content, keys, (-1,)) if at(content, keys) else np.zeros(0)
    if radial.size > 3:
        raise InputError(f"{keys[-1]} has {radial.size} terms, and OpenCV's model three; calibrate with fewer.")
    return np.array([*np.pad(radial[:2], (0, max(0, 2 - radial.size))), *tangential, *radial[2:]])


def _radial_values(content: Any, place: str, name: str, radial: Array) -> dict[Keys, Any]:
    """What to write for the radial coefficients: as many as the file has, or more if they are needed."""
    keys = keys_of(content, place, name)
    count, needed = size_of(content, keys), np.trim_zeros(radial, "b").size
    if needed and not count:
        raise InputError(f"{name}: the file has no {keys[-1]} terms; add `{keys[-1]}: [0.0, 0.0]` to write new ones.")
    return {keys: radial[: max(count, needed)].tolist()} if count else {}


def yaml_text(content: Mapping[str, Any]) -> str:
    """The text of a new YAML file."""
    return yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=120)


def _with_lists(content: Any) -> Any:
    """A copy, since YAML would write one list at two places as an alias; mappings whose keys are numbers are lists."""
    if isinstance(content, list):
        return [*content]
    if not isinstance(content, dict):
        return content
    inside = {key: _with_lists(item) for key, item in content.items()}
    return [*inside.values()] if inside and all(key.isdecimal() for key in inside) else inside


def _about_place(place: Places, name: str) -> AbstractContextManager[None]:
    """What messages about a place begin with: the first of several keys."""
    first, more, _ = (place if isinstance(place, str) else place[0]).format(name).partition("/")
    return about(first if more else "")


def keys_of(content: Any, place: str, name: str) -> Keys:
    """The keys of a place, which are numbers in lists."""
    found: list[str | int] = []
    for key in place.format(name).split("/"):
        of_list, above = isinstance(content, list), key_name(found or key)
        if of_list and not key.isdecimal():
            raise InputError(f"{above} is a list, and must have the key {key!r}; correct it, or copy the file again.")
        if of_list and len(content) < max(2, int(key) + 1):
            raise InputError(f"{above} has not two cameras; give a calibration of a stereo rig.")
        found.append(int(key) if of_list else key)
        content = at(content, (found[-1],))
    return tuple(found)


def stated(content: Any, place: Places, name: str, shape: tuple[int, ...]) -> Array:
    """The array at a place."""
    if not isinstance(place, str):
        return scalars(content, [keys_of(content, one, name) for one in place])
    return numbers(content, keys_of(content, place, name), shape)


def to_write(content: Any, place: Places, name: str, array: Array) -> dict[Keys, Any]:
    """What to write for an array at a place."""
    if isinstance(place, str):
        return matrix_values(content, keys_of(content, place, name), array)
    return {keys_of(content, one, name): float(number) for one, number in zip(place, array.ravel(), strict=True)}
