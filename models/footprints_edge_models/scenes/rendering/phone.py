"""What a phone makes of light: lens, exposure, white balance, noise, and its own retouching.

A typical picture is a good one: faults are small and mostly few. Each has a probability and a
range, in pixels of the picture or in shares of full brightness.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.vectors import vector

Light = NDArray[np.float32]
Rng = np.random.Generator

LUMA = vector([0.25, 0.6, 0.15])


def take_photo(light: Light, rng: Rng) -> NDArray[np.uint8]:
    """A photo of linear light (H, W, 3): uint8 RGB."""
    light = _through_lens(light, rng)
    light = light * (_exposure(light, rng) * _white_balance(light, rng))
    light = _vignetted(light, rng)
    light = _with_noise(light, rng)
    tone = _developed(light, rng)
    tone = _denoised(tone, rng)
    tone = _sharpened(tone, rng)
    return np.asarray(np.clip(tone, 0, 1) * 255 + 0.5, dtype=np.uint8)


def _through_lens(light: Light, rng: Rng) -> Light:
    """Scattered light, defocus, motion, and colours that the lens bends differently."""
    height, width = light.shape[:2]
    if rng.random() < 0.6:
        scattered = _blurred_widely(np.minimum(light, 6), width / 30)
        light = light + (scattered - light) * float(rng.uniform(0.01, 0.07))
    dice = rng.random()
    if dice < 0.12:
        light = _shaken(light, rng)
    elif dice < 0.3:
        light = cv2.GaussianBlur(light, (0, 0), float(rng.uniform(0.3, 0.8)))
    if rng.random() < 0.3:
        step = float(rng.uniform(0.2, 0.9)) / (width / 2)  # at the edge of the picture
        planes = [np.ascontiguousarray(light[..., k]) for k in range(3)]
        for k, sign in ((0, 1), (2, -1)):
            scale = 1 + sign * step
            move = np.array(
                [
                    [scale, 0, (1 - scale) * width / 2],
                    [0, scale, (1 - scale) * height / 2],
                ]
            )
            planes[k] = cv2.warpAffine(
                planes[k], move, (width, height), borderMode=cv2.BORDER_REPLICATE
            )
        light = cv2.merge(planes)
    return light


def _blurred_widely(values: Light, sigma_px: float) -> Light:
    """A Gaussian blur of many pixels, computed on a small picture."""
    small = cv2.resize(values, None, fx=1 / 8, fy=1 / 8, interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), sigma_px / 8)
    size = (values.shape[1], values.shape[0])
    return np.asarray(cv2.resize(small, size, interpolation=cv2.INTER_LINEAR), np.float32)


def _shaken(light: Light, rng: Rng) -> Light:
    """Motion blur along a slightly bent way of up to 6 pixels."""
    long_px = float(rng.uniform(1.2, 6))
    angle, bend = rng.uniform(0, 2 * np.pi), rng.normal(0, 0.4)
    side = 2 * int(np.ceil(long_px / 2)) + 3
    kernel = np.zeros((side, side), np.float32)
    for share in np.linspace(-0.5, 0.5, 16):
        at = angle + bend * share
        x, y = side // 2 + long_px * share * np.array([np.cos(at), np.sin(at)])
        column, row = int(x), int(y)
        right, down = x - column, y - row
        kernel[row, column] += (1 - right) * (1 - down)
        kernel[row, column + 1] += right * (1 - down)
        kernel[row + 1, column] += (1 - right) * down
        kernel[row + 1, column + 1] += right * down
    return np.asarray(cv2.filter2D(light, -1, kernel / kernel.sum()))


def _exposure(light: Light, rng: Rng) -> float:
    """Meters the middle more than the edges, saves highlights, and errs by a third of a stop."""
    small = cv2.resize(light, (32, 32), interpolation=cv2.INTER_AREA) @ LUMA
    y, x = np.ogrid[-1:1:32j, -1:1:32j]
    weight = np.exp(-(x**2 + y**2))
    top = max(float(np.quantile(small, 0.95)), 1e-4)
    middle = np.exp((np.log(np.maximum(small, 0.02 * top)) * weight).sum() / weight.sum())
    return float(min(0.12 / middle, 1.8 / top) * np.exp(rng.normal(0, 0.28)))


def _white_balance(light: Light, rng: Rng) -> Light:
    """Takes most of the light's colour away, with an error."""
    pixels = light[::4, ::4].reshape(-1, 3).astype(np.float64)
    grey = pixels @ LUMA
    pixels = pixels[(grey > np.quantile(grey, 0.2)) & (grey <= np.quantile(grey, 0.97))]
    mean = (pixels**2).mean(axis=0) ** 0.5 + 1e-6 if len(pixels) else np.ones(3)
    gains = np.clip((mean.mean() / mean) ** rng.uniform(0.6, 0.95), 0.65, 1.6)
    gains = gains * np.exp(rng.normal(0, 0.03, 3))
    return vector(gains / (gains @ LUMA))


def _vignetted(light: Light, rng: Rng) -> Light:
    height, width = light.shape[:2]
    y, x = np.ogrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    strength = rng.uniform(0, 0.3) if rng.random() < 0.7 else 0.0
    shade = (1 - strength * (x**2 + y**2) / 2).astype(np.float32)
    return np.asarray(light * shade[..., None])


def _with_noise(light: Light, rng: Rng) -> Light:
    """Shot noise, whose variance grows with light, and read noise; less of it in small pictures."""
    height, width = light.shape[:2]
    shot = float(np.exp(rng.normal(np.log(0.008), 0.7)))
    read = shot * rng.uniform(0.05, 0.2)
    grain = rng.standard_normal((height, width, 3), dtype=np.float32)
    if rng.random() < 0.5:  # coarse where the phone has reduced noise already
        grain = cv2.GaussianBlur(grain, (0, 0), float(rng.uniform(0.5, 0.9))) * 1.7
    return np.asarray(light + grain * np.sqrt(shot**2 * np.clip(light, 0, 1) + read**2))


def _developed(light: Light, rng: Rng) -> Light:
    """Local and global tone curve, saturation: light to tone, 0 to 1."""
    light = np.maximum(light, 0)
    level: Light = np.maximum(light @ LUMA, 1e-4)
    if rng.random() < 0.7:  # shadows are lifted and highlights held, as far as the eye forgives it
        width = light.shape[1]
        around = _blurred_widely(np.log(level), width / 14)
        strength = rng.uniform(0.0, 0.2)
        gain: Light = np.exp(strength * (np.log(0.14) - around)).astype(np.float32)
        light = light * gain[..., None]
    white = float(rng.uniform(1.0, 2.2))
    light = np.asarray(light * (1 + light / white**2) / (1 + light) * (1.25 + 0.25 / white))
    black = float(rng.uniform(0, 0.016)) if rng.random() < 0.8 else 0.0
    tone = np.clip(light - black, 0, 1) ** np.float32(1 / 2.2)
    curve = float(np.clip(rng.normal(1.15, 0.3), 0.2, 1.8))
    tone = tone + curve * (tone - 0.45) * tone * (1 - tone) * 1.6
    saturation = float(np.clip(rng.normal(1.0, 0.15), 0.6, 1.4))
    grey = (tone @ vector([0.3, 0.59, 0.11]))[..., None]
    pale = 1 - np.clip((grey - 0.85) / 0.15, 0, 1)  # what is nearly white is white
    return np.asarray(grey + (tone - grey) * (saturation * pale), np.float32)


def _denoised(tone: Light, rng: Rng) -> Light:
    """Smears what is fainter than edges, as phones do in poor light."""
    if rng.random() > 0.3:
        return tone
    return np.asarray(
        cv2.bilateralFilter(np.clip(tone, 0, 1), 5, float(rng.uniform(0.02, 0.07)), 1.6)
    )


def _sharpened(tone: Light, rng: Rng) -> Light:
    """Unsharp masking, with its halo."""
    if rng.random() > 0.9:
        return tone
    soft = cv2.GaussianBlur(tone, (0, 0), float(rng.uniform(0.6, 1.3)))
    return np.asarray(tone + (tone - soft) * float(rng.uniform(0.3, 1.3)))
