"""Tables 1 and 2 of Muhovič and Perš, "Correcting Decalibration of Stereo Cameras in Self-Driving Vehicles"."""

from typing import NamedTuple


class Published(NamedTuple):
    """One row: counts before, after, and with the manual calibration."""

    sequence: int
    image: int
    starred: bool
    score_initial: int
    score_final: int
    score_reference: int

    @property
    def ratio(self) -> float:
        """The paper's r = N_o / N_GT."""
        return self.score_final / self.score_reference


TABLE_1 = (
    Published(67, 9, False, 4895, 41033, 90639),
    Published(67, 9, False, 78435, 90646, 90639),
    Published(71, 5, False, 57160, 116658, 111665),
    Published(71, 10, False, 71164, 168833, 174877),
    Published(71, 10, False, 4498, 19311, 174877),
    Published(103, 1, False, 15928, 91393, 193982),
    Published(104, 1, False, 41373, 109165, 213418),
    Published(104, 4, False, 144585, 298331, 415226),
    Published(104, 5, False, 76947, 137803, 208970),
    Published(104, 5, False, 121128, 195966, 208970),
    Published(104, 6, False, 113290, 149840, 237280),
)

TABLE_2 = (
    Published(60, 1, False, 164402, 315856, 249980),
    Published(60, 2, False, 225790, 304206, 308937),
    Published(60, 3, False, 125789, 255050, 283294),
    Published(65, 1, False, 73988, 119977, 103851),
    Published(65, 2, True, 325230, 386966, 378874),
    Published(65, 3, False, 345512, 467605, 447601),
    Published(67, 1, False, 206991, 236614, 235365),
    Published(67, 2, False, 63970, 78248, 77895),
    Published(67, 3, False, 173553, 230362, 242878),
    Published(71, 1, False, 9696, 227088, 208646),
    Published(71, 2, True, 0, 5241, 33118),
    Published(71, 3, True, 489, 86286, 82127),
    Published(90, 1, False, 113421, 301904, 291940),
    Published(90, 2, False, 88752, 338497, 397074),
    Published(90, 3, True, 2516, 177083, 95813),
    Published(103, 1, False, 13654, 204456, 193982),
    Published(103, 2, False, 90802, 282952, 281590),
    Published(103, 3, False, 135161, 339999, 334506),
    Published(104, 1, False, 58423, 232379, 213418),
    Published(104, 2, False, 104594, 297483, 262483),
    Published(104, 3, False, 83695, 362732, 318165),
)
