"""Random textures: fractal noise, and periodic fields with a given spectrum."""

import cv2
import numpy as np
from jaxtyping import Float

Texture = Float[np.ndarray, "_ _"]


def fractal(
    rng: np.random.Generator,
    shape: tuple[int, int],
    cell: tuple[float, float],
    octaves: int = 6,
    gain: float = 0.6,
) -> Texture:
    """Fractal noise (h, w) float32 of zero mean; its rms value is 0.8 to 0.9.

    Each octave is half as wide as the one before and `gain` times as strong. It is added to the upsampled sum of the
    coarser ones, so that only the last one is drawn at full resolution.

    Args:
        shape: of the result, (rows, columns).
        cell: size of the grid cells of the first octave, in texels (rows, columns).
    """
    total, power, amplitude = np.zeros((2, 2), np.float32), 0.0, 1.0
    for index in range(octaves):
        grid = [min(n, int(np.ceil(n * 2**index / max(c, 1.0))) + 1) for n, c in zip(shape, cell, strict=True)]
        total = _enlarged(total, grid) + np.float32(amplitude) * rng.standard_normal(grid, dtype=np.float32)
        power, amplitude = power + amplitude**2, amplitude * gain
        if tuple(grid) == tuple(shape):
            break
    return _enlarged(total, shape) * np.float32(0.9 / np.sqrt(power))


def _enlarged(image: Texture, shape) -> Texture:
    return cv2.resize(image, (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)


def periodic(rng: np.random.Generator, size: int, spectrum) -> Texture:
    """A periodic Gaussian random field (size, size) float32 of zero mean and unit variance.

    `spectrum(kx, ky)` is its amplitude spectrum, with kx and ky in cycles per tile.
    """
    ky = np.fft.fftfreq(size, 1.0 / size)[:, None]
    kx = np.fft.rfftfreq(size, 1.0 / size)[None, :]
    white = np.fft.rfft2(rng.standard_normal((size, size)))
    field = np.fft.irfft2(white * spectrum(kx, ky), s=(size, size))
    field -= field.mean()
    return (field / field.std()).astype(np.float32)


def wrapped(field: Float[np.ndarray, "n n *c"]) -> Float[np.ndarray, "m m *c"]:
    """A periodic field, float32, with its first row and column once more at the end, for `tile_at`."""
    ends = [(0, 1), (0, 1), (0, 0)]
    return np.ascontiguousarray(np.pad(field, ends[: field.ndim], mode="wrap"), np.float32)


def tile_at(tile: Float[np.ndarray, "m m *c"], u: Texture, v: Texture) -> Float[np.ndarray, "h w *c"]:
    """Values of a `wrapped` field at (u, v) in periods."""
    u, v = ((at - np.floor(at)) * np.float32(tile.shape[0] - 1) for at in (u, v))
    return cv2.remap(tile, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def wave_slopes(rng: np.random.Generator, size: int, waves: float, heading: float) -> Float[np.ndarray, "n n 2"]:
    """Slopes (d/dx, d/dy) of a periodic sea surface, (size, size, 2) float32 with a mean squared slope of 1.

    About `waves` waves cross the tile, most of them along `heading` [rad].
    """

    def spectrum(kx, ky):
        k = np.hypot(kx, ky) + 1e-9
        along = np.cos(np.arctan2(ky, kx) - heading)
        # Log-normal about `waves`, with a cos^2 spread of directions; widths chosen to look right.
        return np.exp(-0.5 * (np.log(k / waves) / 0.35) ** 2) * (0.35 + along**2)

    height = np.fft.fft2(periodic(rng, size, spectrum))
    k = np.fft.fftfreq(size, 1.0 / size)
    slopes = [np.fft.ifft2(1j * axis * height).real for axis in (k[None, :], k[:, None])]
    stacked = np.stack(slopes, axis=-1)
    return (stacked / np.sqrt((stacked**2).sum(-1).mean())).astype(np.float32)
