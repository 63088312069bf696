"""Freed intrinsics, shared by recordings: rows come right over the view, and nothing is taken that does not help."""

import weakref
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import stereorecal as sr
from stereorecal.geometry import changed_camera, view
from stereorecal.objectives import Parameters, Reach, row_chart
from stereorecal.recalibration import IntrinsicsOutcome, _unseen, chosen_frames, sharing
from stereorecal.recalibration._effects import rows_apart
from stereorecal.recalibration._frames import MOST_FRAMES
from stereorecal.recalibration._intrinsics import Gain, outcome
from stereorecal.recalibration._joint import Member, joint, solved_together
from stereorecal.recalibration._ranges import NONE, Beams
from stereorecal.recalibration._solved import Solved
from stereorecal.recalibration._sums import Sums, calmed
from stereorecal.scoring import Correspondences

SIZE = (320, 240)
TRUE = sr.synthetic.default_rig().resized(SIZE)
WRONG = replace(
    TRUE,
    left=changed_camera(TRUE.left, {"f": 0.002, "cy": 0.7, "k1": 0.012, "k2": -0.02}),
    right=changed_camera(TRUE.right, {"f": -0.003, "cy": -0.5, "k1": -0.008, "k2": 0.02}),
)
BOTH = ("extrinsics", "intrinsics")


def over_the_view(rig: sr.StereoRig) -> float:
    """Root mean square of the rows of points at ten baselines, pixels."""
    apart = rows_apart(rig, TRUE, view(rig), np.linspace(0, 319, 17), np.linspace(0, 239, 13))[0]
    return float(np.sqrt(np.nanmean(apart**2)))


@pytest.fixture(scope="module")
def scenes() -> list[sr.Scene]:
    kinds = [("harbour", 3), ("coast", 4), ("street", 5), ("harbour", 6), ("street", 7)]
    return [sr.synthetic.render(kind, seed, rig=TRUE) for kind, seed in kinds]


@pytest.fixture(scope="module")
def given_wrong(scenes) -> list[sr.Scene]:
    return [replace(scene, rig=WRONG) for scene in scenes]


def test_one_rig(given_wrong):
    """All recordings share the extrinsics too: rows come right where no correspondence was."""
    repairs = sr.recalibrate_many(given_wrong, free=BOTH, extrinsics="one")
    found = [repair.solution for repair in repairs]
    assert all(solution.accepted for solution in found)
    assert {solution.intrinsics.outcome for solution in found} == {IntrinsicsOutcome.REFINED}
    assert over_the_view(WRONG) > 0.4
    for solution in found:
        np.testing.assert_array_equal(solution.rig.extrinsics, found[0].rig.extrinsics)
        assert over_the_view(solution.rig) < 0.08
        assert solution.intrinsics.freed_px < 0.7 * solution.intrinsics.fixed_px
    assert {"left.f", "right.f"} <= set(found[0].intrinsics.undetermined)  # against each other, and against depth
    text = str(found[0])
    assert "left.k1" in text
    assert "px freed" in text


@pytest.mark.slow
def test_each_its_own_extrinsics_on_any_executor(given_wrong):
    alone = sr.recalibrate_many(given_wrong, free=BOTH)
    with ThreadPoolExecutor(2) as pool:
        pooled = sr.recalibrate_many(given_wrong, free=BOTH, executor=pool)
    for one, other in zip(alone, pooled, strict=True):
        np.testing.assert_array_equal(one.solution.candidate.extrinsics, other.solution.candidate.extrinsics)
        np.testing.assert_array_equal(one.solution.candidate.left.matrix, other.solution.candidate.left.matrix)
    matrices = [repair.solution.candidate.left.matrix for repair in alone]
    assert all(np.array_equal(matrix, matrices[0]) for matrix in matrices)
    assert not np.array_equal(alone[0].solution.candidate.extrinsics, alone[1].solution.candidate.extrinsics)
    # One of them suffices to say that the lenses are known: the others are unsure of their own extrinsics.
    seen, expected = alone[0].solution.intrinsics, [repair.solution.expected.rows_px for repair in alone]
    assert seen.taken
    assert seen.expected_px == pytest.approx(min(expected), rel=1e-3)
    assert min(expected) < 0.9 * expected[0]


@pytest.mark.slow
def test_right_intrinsics_stay(scenes):
    """Nothing to gain: they are kept, and the repair is that of the extrinsics, which are still one for all."""
    off = TRUE.with_extrinsics(TRUE.extrinsics + np.radians([0.5, 0.3, -0.4, 0, 0, 0]))
    repairs = sr.recalibrate_many([replace(s, rig=off) for s in scenes], free=BOTH, extrinsics="one")
    for repair in repairs:
        assert repair.solution.intrinsics.outcome is IntrinsicsOutcome.NO_GAIN
        assert repair.solution.accepted
        assert repair.solution.rig.left is off.left
        np.testing.assert_array_equal(repair.solution.rig.extrinsics, repairs[0].solution.rig.extrinsics)
        assert np.abs(np.degrees(repair.solution.rig.extrinsics - TRUE.extrinsics)[:3]).max() < 0.03


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("scene", [1, 4])
def test_one_frame_is_not_enough(given_wrong, scene):
    """What is missing is said, and the intrinsics stay."""
    ranges_or_baseline = sr.Parameters((*BOTH, "baseline"))  # solved for with independent deviations
    solution = sr.recalibrate(WRONG, given_wrong[scene].pairs, free=ranges_or_baseline)
    assert solution.intrinsics is not None
    assert solution.intrinsics.outcome is IntrinsicsOutcome.TOO_UNCERTAIN
    assert solution.intrinsics.expected_px > 0.1
    assert solution.intrinsics.freed_px < solution.intrinsics.fixed_px  # rows alone would have taken them
    for rig in (solution.rig, solution.candidate):
        np.testing.assert_array_equal(rig.left.matrix, WRONG.left.matrix)
        np.testing.assert_array_equal(rig.right.distortion, WRONG.right.distortion)
    assert "add scenes at other depths and places" in str(solution)
    data = solution.intrinsics.as_dict()
    assert data["parameters"]["left.f"]["unit"] == "%"


@pytest.mark.slow
def test_a_lens_that_does_not_fit_is_said(given_wrong, scenes):
    """The misfit is radial: the way out is named, unless it was tried already."""
    lens = changed_camera(TRUE.left, {"k1": 0.03})
    wrong, right = (sr.recalibrate(replace(TRUE, left=left), scenes[1].pairs) for left in (lens, TRUE.left))
    said = f"the intrinsics do not fit: {wrong.misfit.alike:.2f} px of the rows' error is systematic"
    assert f"misfit   {said}; free them with several scenes" in str(wrong)
    assert "intrinsics" not in str(right)
    tried = replace(wrong, intrinsics=sr.recalibrate(WRONG, given_wrong[1].pairs, free=BOTH).intrinsics)
    assert said in str(tried)
    assert "free them" not in str(tried)


@pytest.mark.slow
def test_fog_takes_no_part(given_wrong):
    noise = np.random.default_rng(0)
    left, right = (noise.normal(128, 0.5, SIZE[::-1]).round() for _ in "lr")
    fog = sr.Scene("fog", WRONG, (sr.make_pair(left, right),))
    (alone,) = sr.recalibrate_many(fog, free=BOTH)
    assert alone.solution.intrinsics.outcome is IntrinsicsOutcome.NOT_SOLVED
    *others, last = sr.recalibrate_many([*given_wrong, fog], free=BOTH, extrinsics="one")
    assert not last.solution.accepted
    assert last.solution.intrinsics.outcome is IntrinsicsOutcome.NOT_HERE
    assert not last.solution.intrinsics.taken
    assert others[0].solution.intrinsics.taken


def test_rigs_that_differ_share_nothing(given_wrong):
    with pytest.raises(sr.InputError, match="other intrinsics"):
        sr.recalibrate_many([given_wrong[0], replace(given_wrong[1], rig=TRUE)], free=BOTH)
    moved = replace(given_wrong[1], rig=WRONG.with_extrinsics(WRONG.extrinsics * 1.001))
    with pytest.raises(sr.InputError, match="other extrinsics"):
        sr.recalibrate_many([given_wrong[0], moved], free=BOTH, extrinsics="one")
    with pytest.raises(sr.InputError, match="did you mean each"):
        sr.recalibrate_many(given_wrong, free=BOTH, extrinsics="eac")


def long(number: int = 100) -> sr.Scene:
    """Frames of which every seventh has the most texture: a grating."""
    noise, made = np.random.default_rng(0), []
    for index in range(number):
        step = 20.0 if index % 7 == 5 else 2.0
        image = np.clip(128 + noise.normal(0, step, (48, 64)), 0, 255).astype(np.float32)
        made.append(sr.Pair(image, image[::-1].copy(), str(index)))
    return sr.Scene("long", TRUE.resized((64, 48)), tuple(made))


def test_long_recordings_are_looked_at_in_part():
    """Of each stretch the frame with the most texture; and those that ranges name."""
    scene = long()
    ((some,), _) = sharing([scene], Parameters(BOTH), (), "each", sr.Schedule.default())
    numbers = [int(pair.name) for pair in some.pairs]
    assert len(numbers) == MOST_FRAMES
    assert numbers == sorted(numbers)
    assert max(np.diff(numbers)) < 10
    assert sum(number % 7 == 5 for number in numbers) >= 13  # of 14 that there are, two in one stretch
    named = [sr.Range("1", (5.0, 5.0), 3.0)]
    ((ranged,), (found,)) = sharing([scene], Parameters((*BOTH, "baseline")), named, "each", sr.Schedule.default())
    assert [int(pair.name) for pair in ranged.pairs] == sorted({1, *numbers})
    assert found.pair is ranged.pairs[[pair.name for pair in ranged.pairs].index("1")]
    ((every,), _) = sharing([scene], Parameters(), (), "each", sr.Schedule.default())
    assert len(every.pairs) == 100


def test_a_long_folder_is_read_in_part(tmp_path):
    """Frames that are not chosen are not kept."""
    sr.io.save_scene(long(40), tmp_path / "long")
    alive: list[weakref.ref] = []

    def choose(pairs):
        assert not isinstance(pairs, tuple)  # they are read when they are asked for
        for pair in pairs:
            alive.append(weakref.ref(pair))
        del pair
        assert sum(ref() is not None for ref in alive) == 0
        return chosen_frames(pairs)

    scene = sr.io.load_scene(tmp_path / "long", choose=choose)
    assert len(scene.pairs) == MOST_FRAMES


def test_a_repair_outlives_a_problem_that_cannot_be_solved(given_wrong, monkeypatch):
    def singular(*_, **__):
        raise np.linalg.LinAlgError("singular matrix")

    monkeypatch.setattr("stereorecal.recalibration._recalibrate.together", singular)
    solution = sr.recalibrate(WRONG, given_wrong[0].pairs, free=BOTH, prior="exact")
    assert solution.intrinsics.outcome is IntrinsicsOutcome.NOT_SOLVED
    assert solution.found is not None


def test_frames_are_counted_as_they_were_given(scenes, monkeypatch):
    """Where only some of many are looked at."""
    monkeypatch.setattr("stereorecal.recalibration._frames.chosen_frames", lambda pairs: pairs[1:2])
    pairs = [replace(scene.pairs[0], name=scene.name) for scene in scenes[:2]]
    off = TRUE.with_extrinsics(TRUE.extrinsics + np.radians([0.5, 0.3, -0.4, 0, 0, 0]))
    solution = sr.recalibrate(off, pairs, free=("rotation", "left.k1"))
    assert (solution.looked_at, solution.kept) == ((1,), (0,))
    assert sr.recalibrate(off, pairs[1:], free="rotation").score_before == solution.score_before


def test_nothing_but_the_rotation_moves(scenes):
    off = TRUE.with_extrinsics(TRUE.extrinsics + np.array([*np.radians([1.0, 0.5, -1.0]), 0, 0, 0]))
    solution = sr.recalibrate(off, scenes[0].pairs, free="rotation")
    assert solution.accepted
    np.testing.assert_array_equal(solution.rig.extrinsics[3:], off.extrinsics[3:])
    assert np.abs(np.degrees(solution.rig.extrinsics[:3] - TRUE.extrinsics[:3])).max() < 0.05
    assert solution.covariance.shape == (3, 3)
    assert solution.uncertainty.names == ("pitch", "yaw", "roll")


def test_intrinsics_without_extrinsics(scenes):
    with pytest.raises(sr.InputError, match="free them as well"):
        sr.recalibrate(TRUE, scenes[0].pairs, free="intrinsics")


# --- the linear problem ---------------------------------------------------------------------------------------


def members(
    seed: int,
    number: int = 3,
    noise: float = 0.1,
    given: sr.StereoRig = WRONG,
    free: Parameters | None = None,
    stretch: float = 0.0,
) -> tuple[Member, ...]:
    """Recordings of random points, under a given rig; each with other extrinsics. The right image may be stretched."""
    rng, chart = np.random.default_rng(seed), row_chart(given, Reach(), free or Parameters(BOTH))
    made = []
    for _ in range(number):
        rig = TRUE.with_extrinsics(TRUE.extrinsics + np.array([*rng.normal(0, 0.003, 3), 0, 0, 0]))
        pixels = rng.uniform([10, 10], [310, 230], (2, 400, 2))
        points = rig.left.rays(pixels) * rng.uniform(2, 20, (2, 400, 1))
        there = rig.right.project(points @ rig.rotation.T + rig.translation) + rng.normal(0, noise, pixels.shape)
        there[..., 1] += stretch * (there[..., 1] - 120.0)
        tile = (pixels[..., 1] // 40 * 8 + pixels[..., 0] // 40).astype(np.int32) + np.array([[0], [48]], np.int32)
        rays = given.left.rays(pixels), given.right.rays(there)
        scale = (np.asarray(n, np.float32) for n in (300.0, 1.0, 1.0))
        found = Correspondences(*rays, np.ones(tile.shape), tile, *scale)
        made.append(Member(chart, found, np.zeros(chart.dim)))
    return tuple(made)


@pytest.mark.parametrize("frames", [1, 4, 400])
def test_votes_are_bounded(frames):
    """However many rows a tile has, and however many frames show its place: it tells as much as one row that errs as
    they do together."""
    weight = np.full(2 * frames, 1e6)
    normal = weight[:, None, None] * np.ones((1, 1))
    rows = np.zeros((2 * frames, 1))
    place = np.repeat([3, 17], frames)
    part = Sums(normal, normal, rows, rows, weight, np.tile(np.arange(frames), 2), place)
    for parts in ([part], [part.of(part.frame % 2 == 0), part.of(part.frame % 2 == 1)]):
        information = sum(one.normal[one.place == 3].sum() for one in calmed(parts))
        assert information == pytest.approx(1.0 / (0.02**2 + 0.05**2 / frames), rel=0.01)


GAINS = Gain(np.full(40, 0.1) + 0.01 * (-1.0) ** np.arange(40), 0.1, np.full(40, 0.1), 0.0)
OUTCOMES = {
    "a gain everywhere": (IntrinsicsOutcome.REFINED, {}, {}),
    "nothing to compare with": (IntrinsicsOutcome.REFINED, {"elsewhere": None}, {}),
    "a comparison that failed": (IntrinsicsOutcome.ELSEWHERE_WORSE, {"elsewhere": np.nan}, {}),
    "no gain elsewhere": (IntrinsicsOutcome.ELSEWHERE_WORSE, {"elsewhere": 0.004}, {}),
    "no gain": (IntrinsicsOutcome.NO_GAIN, {"by_place": np.full(40, 0.004)}, {}),
    "no number": (IntrinsicsOutcome.NO_GAIN, {"by_place": np.full(40, np.nan)}, {}),
    "stretched images": (IntrinsicsOutcome.STRETCHED, {"over_stretch": np.full(40, 0.001)}, {}),
    "a region worse": (IntrinsicsOutcome.REGIONS_WORSE, {"worse": 0.2}, {}),
    "little shown": (IntrinsicsOutcome.TOO_LITTLE_SHOWN, {}, {"shown": 0.5}),
    "uncertain": (IntrinsicsOutcome.TOO_UNCERTAIN, {}, {"expected_px": 0.2}),
    "uncertain beyond numbers": (IntrinsicsOutcome.TOO_UNCERTAIN, {}, {"expected_px": np.nan}),
    "far on all together": (IntrinsicsOutcome.IMPLAUSIBLE, {}, {"z": np.full(10, 0.5)}),
    "at the edge": (IntrinsicsOutcome.IMPLAUSIBLE, {}, {"z": np.eye(10)[0]}),
}


@pytest.mark.parametrize("case", OUTCOMES)
def test_outcomes(case):
    expected, gains, others = OUTCOMES[case]
    facts = {"shown": 1.0, "expected_px": 0.05, "z": np.full(10, 0.1), "prior": 1 / 6} | others
    assert outcome(replace(GAINS, **gains), **facts) is expected


def solved(found: tuple[Member, ...], free: Parameters) -> Solved:
    """As of recordings that started from the rig of the chart."""
    rig = found[0].chart.rig
    recordings = [SimpleNamespace(repair=SimpleNamespace(candidate=rig, view=view(rig)))] * len(found)
    return Solved(recordings, solved_together(found, 5), free, (NONE,) * len(found))


@pytest.mark.parametrize("stretch", [0.0, 0.005])
def test_a_stretched_image_is_no_focal_length(stretch):
    """A right image that was resized out of shape is explained by focal lengths; a stretch explains it as well."""
    rig = TRUE if stretch else WRONG
    found = solved(members(0, given=rig, stretch=stretch), Parameters(BOTH))
    gain, over = (found.gain(before).mean() for before in (found.fixed_unseen, found.stretched_unseen))
    assert gain > 0.02
    assert over < 0.002 if stretch else over > 0.008


@pytest.mark.slow
def test_lenses_far_beyond_their_priors():
    """What was said of them is wrong: they are not taken, and the way out is named. With honest priors they are."""
    tight = {"f": 0.03, "cx": 0.1, "cy": 0.1, "k1": 0.001, "k2": 0.002}
    said = {f"{side}.{name}": sigma for side in ("left", "right") for name, sigma in tight.items()}
    for priors, expected in ((said, IntrinsicsOutcome.IMPLAUSIBLE), ({}, IntrinsicsOutcome.REFINED)):
        free = Parameters(BOTH, priors)
        seen = solved(members(0, free=free), free).judged()
        assert seen.outcome is expected
    assert "wider" in IntrinsicsOutcome.IMPLAUSIBLE.value


def test_what_is_compared_knows_the_ranges_too():
    """With the intrinsics as they were, the length of the baseline is as free as with others."""
    free = Parameters((*BOTH, "baseline"))
    found = solved(members(0, free=free), free)
    assert found.fixed[0].chart.names == ("pitch", "yaw", "roll", "y", "z", "baseline")


@settings(max_examples=5)
@given(seed=st.integers(0, 99))
def test_the_solution_is_a_minimum_and_shared(seed):
    solved = solved_together(members(seed), 5)
    for member in solved[1:]:
        np.testing.assert_array_equal(member.z[5:], solved[0].z[5:])
    assert np.abs(joint(solved, 5).shift()).max() < 1e-3
    again = [np.median(np.abs(m.facts().residual)) for m in solved]
    assert max(again) < 0.12  # the median of the noise of one pixel coordinate, 0.1 px, and the fit's own


@settings(max_examples=3)
@given(seed=st.integers(0, 99))
def test_cross_validation_by_hand(seed):
    """Leaving a recording out gives what solving the others does, with the votes of places as they were."""
    solved = solved_together(members(seed), 5)
    problem = joint(solved, 5)
    without = problem.shift(lambda m, part: np.full(len(part.place), m != 0))
    others = replace(problem, parts=problem.parts[1:], zs=problem.zs[1:], of_ranges=problem.of_ranges[1:])
    np.testing.assert_allclose(without[5:], others.shift(), atol=1e-9)


def test_nothing_leaks_into_what_is_unseen():
    """Rows of one place that are spoiled: solutions that saw them bend to them, those that judge it do not."""
    found = solved_together(members(0), 5)
    spoiled = []
    for member in found:
        rays = np.array(member.found.right)
        rays[..., 1] += 0.01 * (np.asarray(member.found.tile) % 48 == 20)
        spoiled.append(replace(member, found=replace(member.found, right=rays)))
    problem, clean = joint(spoiled, 5), joint(found, 5)

    def elsewhere(_, part):
        return part.place != 20

    np.testing.assert_allclose(problem.shift(elsewhere), clean.shift(elsewhere), atol=2e-3)
    by_place = _unseen.by_place(spoiled, 5)
    for unseen, member in zip(by_place, spoiled, strict=True):
        facts = member.facts()
        there = np.unique(facts.tile) % 48 == 20
        assert unseen[there].min() > 2.5  # three pixels, as they are


def test_the_ranges_of_what_is_left_out_have_no_say():
    found = solved_together(members(0, free=Parameters((*BOTH, "baseline"))), 5)
    pixels = np.array([[60.0, 60.0], [250.0, 180.0], [160.0, 100.0]])
    seen = Beams(pixels, pixels - [[9.0, 0.0]], np.full(3, 12.0), np.full(3, 0.01), np.full(3, 0.05))
    ranged = (replace(found[0], beams=seen), *found[1:])
    plain, odd = (_unseen.by_recording(some, 5, np.arange(0)) for some in (found, ranged))
    np.testing.assert_allclose(odd[0], plain[0], atol=1e-12)
    assert np.abs(odd[1] - plain[1]).max() > 1e-3  # it does take part where others are judged


def test_the_covariance_knows_an_offset_that_all_rows_share():
    """As that of a single repair does."""
    (one,) = solved_together(members(0, number=1, noise=0.01), 5)
    together, alone = joint([one], one.chart.dim).covariance(), one.facts().covariance()
    calm = replace(joint([one], one.chart.dim), scale=1e9).covariance()
    assert alone[0, 0] > 0
    assert together[0, 0] > calm[0, 0]


def test_the_recording_that_judges_had_no_say():
    """Of one whose lenses differ, rows are judged by the lenses of the others."""
    odd = members(0, number=3)[:2] + members(1, number=1, given=TRUE)
    odd = (*odd[:2], replace(odd[2], chart=odd[0].chart))  # rays of true lenses, taken for those of wrong ones
    found = solved_together(odd, 5)
    own, other = (rows[2].mean() for rows in (_unseen.by_place(found, 5), _unseen.by_recording(found, 5, np.arange(0))))
    assert other > 1.2 * own


@pytest.mark.slow
def test_the_covariance_is_honest_of_noise():
    """Shared parameters that are well determined scatter as their covariance says."""
    ends, sigmas = [], []
    for seed in range(12):
        solved = solved_together(members(seed, noise=0.2), 5)
        problem = joint(solved, 5)
        ends.append(problem.z[-10:])
        sigmas.append(np.sqrt(np.diag(problem.covariance()))[-10:])
    names = solved[0].chart.names[5:]
    for name in ("left.k1", "right.k1"):
        index = names.index(name)
        scatter, said = np.std([end[index] for end in ends]), np.median([s[index] for s in sigmas])
        assert 0.3 * said < scatter < 1.6 * said
