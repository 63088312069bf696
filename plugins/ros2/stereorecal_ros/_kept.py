"""What is kept over restarts: the state in one file, what has been applied in another beside it."""

from dataclasses import dataclass
from pathlib import Path

from stereorecal import InputError, StereoRig
from stereorecal.io import next_copy
from stereorecal_ros._applied import Applied, load_applied
from stereorecal_ros._log import Level, Line, numbers

_ZIP = b"PK\x03\x04"  # how a state begins


@dataclass(frozen=True)
class Kept:
    """The places of the two.

    Attributes:
        state: of the state.
        named: whether the user has named that place.
    """

    state: Path
    named: bool = False

    @property
    def applied(self) -> Path:
        """Where is kept what has been applied."""
        return self.state.with_name(f"{self.state.name}.applied.json")

    def check(self) -> None:
        """Refuse a place that is somebody else's: what cannot be read as a state is replaced later.

        Raises:
            InputError: if it is a folder, or was named and is a file of another kind.
        """
        place = self.state
        if place.is_dir():
            raise InputError(f"{place}: is a folder; name a file in it with the parameter state_file.")
        if self.named and place.is_file():
            with place.open("rb") as file:
                begins = file.read(len(_ZIP))
            if begins.strip(b"\0") not in (b"", _ZIP):
                raise InputError(f"{place}: is no state of this node; give another name with the parameter state_file.")

    def read(self, rig: StereoRig) -> tuple[Applied | None, list[Line]]:
        """What has been applied, if the given calibration goes on from it, and lines for the log. A calibration that
        has changed since, as when an old file was restored, wins: both files are set aside."""
        try:
            applied = load_applied(self.applied)
        except InputError as error:
            return None, [set_aside(self.applied, str(error))]
        if applied is None or applied.goes_on(rig):
            return applied, []
        change = f"{numbers(applied.published.rig)} -> {numbers(rig)}"
        said = [(Level.WARN, f"another calibration is given than the one before, and used from now on: {change}")]
        kept = [path for path in (self.state, self.applied) if path.exists()]
        return None, said + [set_aside(path, f"{path}: belongs to the one before.") for path in kept]


def set_aside(path: Path, why: str) -> Line:
    """Rename a file that cannot be used; returns a line for the log.

    Raises:
        OSError: if the folder does not allow it.
    """
    copy = next_copy(path)
    path.rename(copy)
    return Level.WARN, f"{why} It is kept as {copy}, and the watch starts from a new one."
