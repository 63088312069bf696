"""Random textures: octaves of value noise, and periodic fields shaped in the Fourier domain."""

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
    """Octaves of smooth noise (h, w) float32, each half as wide and `gain` times as strong.

    Each octave is laid over the enlarged sum of the coarser ones, so that only the last one costs full size.

    Args:
        cell: grid of the first octave in texels (rows, columns).
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
    """A periodic field (size, size) float32 of unit variance; `spectrum(kx, ky)` is its amplitude spectrum.

    kx and ky count the waves across the tile.
    """
    ky = np.fft.fftfreq(size, 1.0 / size)[:, None]
    kx = np.fft.rfftfreq(size, 1.0 / size)[None, :]
    white = np.fft.rfft2(rng.standard_normal((size, size)))
    field = np.fft.irfft2(white * spectrum(kx, ky), s=(size, size))
    field -= field.mean()
    return (field / field.std()).astype(np.float32)


def wave_slopes(rng: np.random.Generator, size: int, waves: float, heading: float) -> Float[np.ndarray, "n n 2"]:
    """Slopes (d/dx, d/dy) of a periodic sea, `waves` waves wide, that runs along `heading` [rad]."""

    def spectrum(kx, ky):
        k = np.hypot(kx, ky) + 1e-9
        along = np.cos(np.arctan2(ky, kx) - heading)
        return np.exp(-0.5 * (np.log(k / waves) / 0.35) ** 2) * (0.35 + along**2)

    height = np.fft.fft2(periodic(rng, size, spectrum))
    k = np.fft.fftfreq(size, 1.0 / size)
    slopes = [np.fft.ifft2(1j * axis * height).real for axis in (k[None, :], k[:, None])]
    stacked = np.stack(slopes, axis=-1)
    return (stacked / np.sqrt((stacked**2).sum(-1).mean())).astype(np.float32)
