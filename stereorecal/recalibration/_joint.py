"""Recordings of one rig together: each has extrinsics of its own, and they share intrinsics and the baseline's length.

Every recording is a least-squares problem of its own and the shared parameters, linear near its solution, and is
reduced to sums over tiles (`_sums`): what is solved here does not know how many correspondences or images there are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from stereorecal.objectives import RigChart
from stereorecal.recalibration._evidence import SHARED, TILES_OF_A_FRAME, Evidence, evidence, jackknife
from stereorecal.recalibration._misfit import spread_of_misfit
from stereorecal.recalibration._ranges import NONE, Beams
from stereorecal.recalibration._sums import Sums, calmed, sums
from stereorecal.scoring import Correspondences, Loss

_LOSSES = (Loss.SOFT_L1, Loss.SOFT_L1, Loss.WELSCH, Loss.WELSCH, Loss.WELSCH, Loss.WELSCH)

Keep = Callable[[int, Sums], Bool[np.ndarray, "t"]]  # which tiles of which member take part


@dataclass(frozen=True, eq=False)
class Member:
    """One recording among others.

    Attributes:
        chart: its own parameters, then those that all share; its rig is what the recording started from.
        found: correspondences, with the rays that the cameras of the chart's rig give.
        z: (n,) its solution so far.
        beams: ranges of what it shows, with the pixels that the cameras gave.
    """

    chart: RigChart
    found: Correspondences
    z: Float[np.ndarray, "n"]
    beams: Beams = NONE

    def facts(self, loss: Loss = Loss.WELSCH) -> Evidence:
        """The evidence of its rows at its solution."""
        return evidence(self.chart, self.found, self.z, loss)


@dataclass(frozen=True, eq=False)
class Joint:
    """The least-squares problem of all members: n own parameters of each, one after the other, then the shared ones.

    Attributes:
        parts: the sums of each member's rows.
        zs: the solution of each member.
        own: how many parameters each has for itself.
        prior: standard deviation of each parameter, in half widths of the box.
        scale: pixels at which the rows were measured, per pixel at full size.
        of_ranges: normal matrix and pull of each member's ranges, which take part in every solution.
    """

    parts: tuple[Sums, ...]
    zs: tuple[Float[np.ndarray, "n"], ...]
    own: int
    prior: float
    scale: float
    of_ranges: tuple[tuple[Float[np.ndarray, "n n"], Float[np.ndarray, "n"]], ...]

    @property
    def size(self) -> int:
        """How many parameters there are."""
        return self.own * len(self.parts) + len(self.zs[0]) - self.own

    def where(self, member: int) -> Int[np.ndarray, "n"]:
        """Where the parameters of a member stand among all."""
        first = self.own * member
        return np.concatenate([np.arange(first, first + self.own), np.arange(self.own * len(self.parts), self.size)])

    @property
    def z(self) -> Float[np.ndarray, "N"]:
        """The solution so far."""
        return np.concatenate([*(z[: self.own] for z in self.zs), self.zs[0][self.own :]])

    def normal(self, keep: Keep | None = None, *, bent: bool = False) -> Float[np.ndarray, "N N"]:
        """The normal matrix with those of the ranges and the prior, of the weights or the curvatures of the losses."""
        return self.known + self.of_rows(keep, bent=bent)

    def of_rows(self, keep: Keep | None = None, *, bent: bool = False) -> Float[np.ndarray, "N N"]:
        """The normal matrix of the rows alone."""
        total = np.zeros((self.size, self.size))
        for member, part in enumerate(self.parts):
            here, of_tiles = self.where(member), part.bent if bent else part.normal
            total[np.ix_(here, here)] += of_tiles[_kept(keep, member, part)].sum(0)
        return total

    @property
    def known(self) -> Float[np.ndarray, "N N"]:
        """The normal matrix of what is known beside the rows: the prior, and ranges."""
        total = np.eye(self.size) / self.prior**2
        for member, (normal, _) in enumerate(self.of_ranges):
            total[np.ix_(self.where(member), self.where(member))] += normal
        return total

    @property
    def pull_of_known(self) -> Float[np.ndarray, "N"]:
        """The pull of what is known beside the rows."""
        total = self.z / self.prior**2
        for member, (_, pull) in enumerate(self.of_ranges):
            total[self.where(member)] += pull
        return total

    def gathered(self, name: str, keep: Keep | None = None) -> Float[np.ndarray, "N"]:
        """The sum over the tiles of "pull" or "offset"."""
        total = np.zeros(self.size)
        for member, part in enumerate(self.parts):
            total[self.where(member)] += getattr(part, name)[_kept(keep, member, part)].sum(0)
        return total

    def covariance(self) -> Float[np.ndarray, "N N"]:
        """Of the solution by chance, in units of the box: the jackknife over places, which all members share, and the
        prior, and an offset that all rows share; as `Evidence.covariance`."""
        normal, pull = self.normal(bent=True), self.gathered("pull") + self.pull_of_known
        places = np.unique(np.concatenate([part.place for part in self.parts]))
        if len(places) < 2:
            return np.eye(self.size) * self.prior**2
        ends = []
        for place in places:

            def there(_: int, part: Sums, place: int = place) -> Bool[np.ndarray, "t"]:
                return part.place == place

            without = normal - self.of_rows(there, bent=True)
            ends.append(np.linalg.solve(without, pull - self.gathered("pull", there)))
        inverse = np.linalg.inv(normal)
        shared = SHARED / self.scale * inverse @ self.gathered("offset")
        return jackknife(np.stack(ends)) + inverse @ self.known @ inverse + np.outer(shared, shared)

    def by_misfit(self, pixels: float) -> Float[np.ndarray, "N N"]:
        """What misfit that neighbouring regions share, so many pixels of it, adds to the covariance."""
        pulls = np.zeros((TILES_OF_A_FRAME, self.size))
        for member, part in enumerate(self.parts):
            at = (part.place[:, None], self.where(member)[None])
            np.add.at(pulls, at, part.offset)
        return spread_of_misfit(np.linalg.solve(self.normal(bent=True), pulls.T), pixels)

    def without_ranges(self, member: int) -> "Joint":
        """The problem without the ranges of a member."""
        empty = np.zeros((len(self.zs[0]),) * 2), np.zeros(len(self.zs[0]))
        some = tuple(empty if index == member else one for index, one in enumerate(self.of_ranges))
        return replace(self, of_ranges=some)

    def shift(self, keep: Keep | None = None) -> Float[np.ndarray, "N"]:
        """From `z` to the solution of the tiles that take part, and the prior."""
        return -np.linalg.solve(self.normal(keep), self.gathered("pull", keep) + self.pull_of_known)


def _kept(keep: Keep | None, member: int, part: Sums) -> Bool[np.ndarray, "t"]:
    return np.ones(len(part.place), bool) if keep is None else keep(member, part)


def joint(members: Sequence[Member], own: int, loss: Loss = Loss.WELSCH) -> Joint:
    """The problem of the members at their solutions."""
    parts = calmed([sums(member.facts(loss)) for member in members])
    of_ranges = tuple(member.beams.normal_and_pull(member.chart, member.z) for member in members)
    prior, scale = members[0].chart.prior, float(members[0].found.scale)
    return Joint(parts, tuple(member.z for member in members), own, prior, scale, of_ranges)


def solved_together(members: Sequence[Member], own: int) -> tuple[Member, ...]:
    """The members at their common solution: Gauss-Newton, the weights follow, at the end with a redescending loss."""
    for loss in _LOSSES:
        problem = joint(members, own, loss)
        z = problem.z + problem.shift()
        members = [replace(member, z=z[problem.where(index)]) for index, member in enumerate(members)]
    return tuple(members)
