"""Charts: from the unit box, which strategies see, to rigs, which they do not."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float

from stereorecal._errors import InputError
from stereorecal.geometry import AXES, StereoRig, camera_changes, changed_camera, euler_slopes
from stereorecal.objectives._parameters import BASELINE, EXTRINSICS, SIDES, Parameter, Parameters, Reach

# Standard deviations of the prior in half of the box: twice the reach, which is three of them. The prior holds the
# solver back, and a drift just beyond the reach is better found than cut off.
_WIDE = 6.0
_OF_REACH = 3.0  # the same where the box is as wide as the reach


@dataclass(frozen=True, eq=False)
class RigChart:
    """An affine map from the unit box [-1, 1]^n to the free parameters of a rig; float64.

    Attributes:
        rig: at z = 0.
        parameters: one for each coordinate of z: extrinsics first.
        wide: standard deviations of the prior in half of the box.
    """

    rig: StereoRig
    parameters: tuple[Parameter, ...]
    wide: float = _WIDE

    @property
    def prior(self) -> float:
        """Standard deviation of the prior on each parameter, in half widths of the box."""
        return 1.0 / self.wide

    @property
    def dim(self) -> int:
        """n, the number of free parameters."""
        return len(self.parameters)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The names of the free parameters."""
        return tuple(parameter.name for parameter in self.parameters)

    @cached_property
    def units(self) -> Float[np.ndarray, "n"]:
        """One half width of the box in the units of people: degrees, percent, pixels."""
        return np.array([self.wide * parameter.sigma for parameter in self.parameters])

    @cached_property
    def half_width(self) -> Float[np.ndarray, "n"]:
        """One half width of the box in the units of a rig: rad, metres, fractions, pixels."""
        return self.units * np.array([parameter.in_rig for parameter in self.parameters])

    def extrinsics(self, z: Float[np.ndarray, "*k n"]) -> Float[np.ndarray, "*k 6"]:
        """Pitch, yaw, roll [rad], x, y, z [m] at points of the box."""
        return np.asarray(self.rig.extrinsics, float) + z @ self.extrinsic_slopes

    @cached_property
    def extrinsic_slopes(self) -> Float[np.ndarray, "n 6"]:
        """Derivatives of the extrinsics by the coordinates of the box, the same everywhere."""
        start, found = np.asarray(self.rig.extrinsics, float), np.zeros((self.dim, 6))
        for index, (parameter, width) in enumerate(zip(self.parameters, self.half_width, strict=True)):
            if parameter.name in EXTRINSICS:
                found[index, AXES.index(parameter.name)] = width
            elif parameter.name == BASELINE:  # of another length, in the same direction
                found[index, 3:] = width / float(self.rig.baseline) * start[3:]
        return found

    def pose_slopes(self, rig: StereoRig) -> tuple[list[int], Float[np.ndarray, "m 3 3"], Float[np.ndarray, "m 3"]]:
        """Where the m numbers of the pose are in z, and the derivatives of R and T by them, at a rig of the chart."""
        outer = [index for index, name in enumerate(self.names) if "." not in name]
        by_angles, by_shift = np.split(self.extrinsic_slopes[outer], 2, axis=1)
        return outer, np.tensordot(by_angles, euler_slopes(np.asarray(rig.extrinsics)[:3]), 1), by_shift

    @cached_property
    def lenses(self) -> dict[str, tuple[list[int], list[str]]]:
        """Where the intrinsics of each camera are in z, and what they are called there, such as "k1"."""
        found = {side: ([], []) for side in SIDES}
        for index, name in enumerate(self.names):
            if "." in name:
                side, kind = name.split(".")
                found[side][0].append(index)
                found[side][1].append(kind)
        return found

    def rig_at(self, z: Float[np.ndarray, "n"]) -> StereoRig:
        """The rig at a point of the box. The last one is kept: it is asked for again and again."""
        at, last = z.tobytes(), self._last[0]
        if last is None or last[0] != at:
            self._last[0] = last = at, self._rig_at(z)
        return last[1]

    @cached_property
    def _last(self) -> list[tuple[bytes, StereoRig] | None]:
        return [None]

    def _rig_at(self, z: Float[np.ndarray, "n"]) -> StereoRig:
        change, cameras = self.half_width * z, {}
        for side, (own, kinds) in self.lenses.items():
            if change[own].any():
                changes = dict(zip(kinds, change[own].tolist(), strict=True))
                cameras[side] = changed_camera(getattr(self.rig, side), changes)
        return replace(self.rig, extrinsics=self.extrinsics(z), **cameras)

    def stands_at(self, z: Float[np.ndarray, "n"]) -> bool:
        """Whether a valid rig lies at a point, which may be far outside of the box."""
        try:
            self.rig_at(z)
        except InputError:
            return False
        return True

    def coordinates_of(self, rig: StereoRig) -> Float[np.ndarray, "n"]:
        """The point of the box at which a rig lies, of those that `rig_at` gives."""
        found = self.coordinates(np.asarray(rig.extrinsics))
        for side, (own, kinds) in self.lenses.items():
            changes = camera_changes(getattr(self.rig, side), getattr(rig, side))
            found[own] = [changes[kind] for kind in kinds] / self.half_width[own]
        return found

    def coordinates(self, extrinsics: Float[np.ndarray, "6"]) -> Float[np.ndarray, "n"]:
        """The point of the box with these extrinsics, beyond [-1, 1] where they lie outside of it, and intrinsics as
        they are at its centre."""
        start = np.asarray(self.rig.extrinsics, float)
        change, found = np.asarray(extrinsics, float) - start, np.zeros(self.dim)
        longer = change[3] / start[3] if BASELINE in self.names else 0.0  # only the length moves x
        change[3:] -= longer * start[3:]
        for index, (parameter, width) in enumerate(zip(self.parameters, self.half_width, strict=True)):
            if parameter.name in EXTRINSICS:
                found[index] = change[AXES.index(parameter.name)] / width
            elif parameter.name == BASELINE:
                found[index] = longer * float(self.rig.baseline) / width
        return found


def row_chart(rig: StereoRig, reach: Reach, free: Parameters | None = None) -> RigChart:
    """The box of epipolar residuals: twice as wide as the reach, around the rig; by default of the extrinsics."""
    return RigChart(rig, (free or Parameters()).of(rig, reach))


def count_chart(rig: StereoRig, reach: Reach, free: Parameters | None = None) -> RigChart:
    """The box in which counts are searched: three standard deviations wide on every axis, which is the reach where
    the priors of extrinsics are the default; by default of the extrinsics."""
    return RigChart(rig, (free or Parameters()).of(rig, reach), wide=_OF_REACH)
