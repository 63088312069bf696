"""Which calibration the drivers of the two cameras say, from the CameraInfo that they publish."""

from dataclasses import dataclass, replace

from stereorecal_ros._camera_info import CameraInfo

SETTLED = 2.0  # seconds: a driver is given a new calibration after the other


@dataclass(frozen=True)
class Given:
    """The last CameraInfo of each side. Never changed: another one makes another value.

    Attributes:
        infos: of the left and the right camera, None before the first.
        changed: when one of them changed last, in seconds of any clock; None if that has been followed.
        first: whether no calibration has been followed yet.
    """

    infos: tuple[CameraInfo | None, CameraInfo | None] = (None, None)
    changed: float | None = None
    first: bool = True

    def with_info(self, side: int, info: CameraInfo, now: float) -> "Given":
        """With the one that has come."""
        if info == self.infos[side]:
            return self
        left, right = (info if at == side else old for at, old in enumerate(self.infos))
        return replace(self, infos=(left, right), changed=now)

    def new(self, now: float) -> tuple[CameraInfo, CameraInfo] | None:
        """A calibration that is to be followed: the first at once, another one when both sides have stayed as they are
        for two seconds."""
        left, right = self.infos
        if self.changed is None or left is None or right is None:
            return None
        return (left, right) if self.first or now - self.changed >= SETTLED else None

    def followed(self) -> "Given":
        """After it has been, whether it could be used or not."""
        return replace(self, changed=None, first=False)
