"""Rigs x spoilings x doors: images that show too little change nothing and are no alarm; what they lack is named."""

import json

import cv2
import jax
import numpy as np
import pytest
from fixtures import SAD_48
from spoiled import fog, turned

import stereorecal as sr
from stereorecal.recalibration import Condition, Reason
from stereorecal.scoring import image_quality

SIZE = (320, 240)


def dim(gain: float, level: float):
    """So much of the image's light on a grey level, and noise."""

    def spoil(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        grey = gain * image + level + draw.normal(0, 2, image.shape)
        return np.clip(np.round(grey), 0, 255).astype(np.float32)

    return spoil


def covered(counts: float, kind: type):
    """By a cap: of 16 bit and of floating point, what is stretched to full contrast is noise."""
    return lambda image, draw: (
        np.abs(draw.normal(0, counts, image.shape)) / (1 if kind is np.uint16 else 65535)
    ).astype(kind)


def interlaced(aside: int):
    """A comb matches itself, every second row away from its own."""

    def spoil(image: np.ndarray, draw: np.random.Generator) -> np.ndarray:
        image = np.array(image)
        image[1::2] = np.roll(image, aside, axis=1)[1::2]
        return image

    return spoil


SPOILINGS = {
    "night": (dim(0.03, 4.0), "too dark"),
    "noise on grey": (dim(0.0, 128.0), "too little texture"),
    "fog": (None, ""),
    "a cap, 16 bit": (covered(40.0, np.uint16), "noise"),
    "a cap, floating point": (covered(0.5, np.float32), "noise"),
    # The last two are slow.
    **{f"interlaced by {aside}": (interlaced(aside), "an image is interlaced.") for aside in (1, 2, 4)},
}


@pytest.mark.slow(after=len(SPOILINGS) - 2)
@pytest.mark.parametrize("name", SPOILINGS)
@pytest.mark.parametrize("degrees", [0.38, 0.0, 1.5], ids=["two rows off", "good", "far off"])
def test_it_cannot_be_told(scene, name, degrees):
    shown, (spoil, missing) = scene("harbour", 0, SIZE), SPOILINGS[name]
    (pair,), rig, draw = shown.pairs, turned(shown.rig, degrees), np.random.default_rng(0)
    make = sr.make_pair if name.startswith("a cap") else sr.Pair
    spoiled = make(*(spoil(np.asarray(one), draw) for one in (pair.left, pair.right))) if spoil else fog(SIZE)
    looked, done = (door(rig, [spoiled], matcher=SAD_48) for door in (sr.health, sr.recalibrate))
    for said in (looked, done):
        assert said.reason is Reason.TOO_LITTLE_TEXTURE
        assert said.verdict.startswith("Cannot tell: ")
        assert missing in said.verdict
        assert "every second row" in said.advice
    assert looked.condition is Condition.CANNOT_TELL
    assert done.rig is rig
    assert "±" not in str(done)
    data = json.loads(json.dumps(looked.to_dict(), allow_nan=False))
    assert name != "fog" or (data["row_error_px"], data["estimate"], data["score_before"]["count"]) == (None, None, 0)
    assert name != "fog" or done.row_errors is done.uncertainty is done.covariance is None
    assert name != "fog" or sr.recalibrate(rig, [spoiled], matcher=SAD_48, schedule="count").reason is done.reason
    assert not image_quality(pair).interlaced


def slats(rig: sr.StereoRig, period: float = 0.15) -> sr.Pair:
    """A corridor of slats, all alike, 4 by 3 m and 12 m long, with hardly any grain."""
    draw, images = np.random.default_rng(0), []
    planes = np.array([[0, 2 / 3, 0], [0, -2 / 3, 0], [0.5, 0, 0], [-0.5, 0, 0], [0, 0, 1 / 12]])
    grain = cv2.GaussianBlur(draw.normal(0, 1, (512, 512)).astype(np.float32), (0, 0), 2)
    (width, height), fine = rig.left.size, 3
    x, y = np.meshgrid(*((np.arange(n * fine) + 0.5) / fine - 0.5 for n in (width, height)))
    cameras = ((rig.left, np.eye(3), np.zeros(3)), (rig.right, rig.rotation, rig.translation))
    for camera, rotation, translation in cameras:
        centre = -rotation.T @ translation
        rays = np.asarray(camera.rays(np.stack([x, y], axis=-1).reshape(-1, 2))) @ rotation
        away = (1.0 - planes @ centre)[:, None] / np.maximum(planes @ rays.T, 1e-9)
        plane, points = away.argmin(axis=0), centre + away.min(axis=0)[:, None] * rays
        across = np.where((plane == 2) | (plane == 3), points[:, 2], points[:, 0])
        along = np.where(plane < 2, points[:, 2], points[:, 1])
        at = (np.float32(100.0 * one % 511.0).reshape(x.shape) for one in (across, along))
        light = 102 + 64 * np.sign(np.sin(2 * np.pi * along / period)).reshape(x.shape) + 30 * cv2.remap(grain, *at, 1)
        image = cv2.resize(light.astype(np.float32), (width, height), interpolation=cv2.INTER_AREA)
        images.append(np.clip(np.round(image + draw.normal(0, 2, image.shape)), 0, 255).astype(np.float32))
    return sr.make_pair(*images)


def test_what_repeats_itself_is_not_repaired_by_a_period():
    """Where rows are a slat off, about as much matches as anywhere."""
    rig = sr.synthetic.default_rig().resized(SIZE)
    pair = slats(rig)
    found = sr.recalibrate(sr.synthetic.decalibrate(rig, jax.random.key(5), 2.5, 0.02), pair)
    assert sr.difference(found.candidate, rig).row_error_median > 0.5
    assert not found.accepted
    assert sr.health(rig, pair).condition in (Condition.HEALTHY, Condition.CANNOT_TELL)
