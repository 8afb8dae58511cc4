"""The sensor: exposure, white balance, lens, noise and tone."""

import cv2
import numpy as np
from numpy.typing import NDArray

from footprints_edge_models.scenes.vectors import vector


def photograph(light: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A photo of linear light (H, W, 3): uint8 RGB, with a camera's faults."""
    height, width = light.shape[:2]
    grey = light @ vector([0.25, 0.6, 0.15])
    bright = max(float(np.quantile(grey, 0.85)), 1e-3)
    middle = float(np.exp(np.log(np.clip(grey, 0.1 * bright, 3 * bright)).mean()))
    aim = 0.2 * np.exp(rng.normal(0, 0.3))
    gain = min(aim / middle, 0.95 * np.exp(rng.normal(0, 0.3)) / bright)
    balance = np.exp(rng.normal(0, 0.06, 3)).astype(np.float32)
    light = _scaled(light, np.tile(np.float32(gain) * balance, width))
    if rng.random() < 0.5:  # light scattered in the lens
        glow = cv2.GaussianBlur(np.minimum(light, 4), (0, 0), width / 40)
        light = light + (glow - light) * float(rng.uniform(0.02, 0.1))
    if rng.random() < 0.6:
        y, x = np.ogrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
        shade = (1 - rng.uniform(0, 0.35) * (x**2 + y**2) / 2).astype(np.float32)
        light = _scaled(light, np.repeat(shade, 3, axis=1))
    dice = rng.random()
    if dice < 0.4:
        light = cv2.GaussianBlur(light, (0, 0), float(rng.uniform(0.35, 1.1)))
    elif dice < 0.5:
        light = _shaken(light, rng)
    noise = float(rng.choice([0.002, 0.006, 0.015], p=[0.4, 0.4, 0.2])) * rng.uniform(0.5, 1.5)
    grain = rng.standard_normal((height, width, 3), dtype=np.float32)
    if rng.random() < 0.4:
        grain = cv2.GaussianBlur(grain, (0, 0), 0.7) * 1.8
    light = light + grain * noise * np.sqrt(np.clip(light, 0.02, 1) * 4)
    tone = with_shoulder(np.maximum(light, 0)) ** (1 / 2.2)
    contrast = float(rng.normal(0.25, 0.2))
    tone = tone + contrast * (tone - 0.5) * tone * (1 - tone) * 2
    saturation = float(np.clip(rng.normal(1.0, 0.15), 0.4, 1.5))
    level = cv2.merge([tone @ vector([0.3, 0.59, 0.11])] * 3)
    tone = level + (tone - level) * saturation
    return np.asarray(np.clip(tone, 0, 1) * 255 + 0.5, dtype=np.uint8)


def with_shoulder(light: NDArray[np.float32]) -> NDArray[np.float32]:
    """Linear light that nears 1 where a sensor would clip it."""
    knee = np.float32(0.75)
    over = np.maximum(light - knee, 0)
    return np.asarray(np.minimum(light, knee) + (1 - knee) * (1 - np.exp(-over / (1 - knee))))


def _scaled(light: NDArray[np.float32], by: NDArray[np.float32]) -> NDArray[np.float32]:
    """Light (H, W, 3) times (H, 3 W), or (3 W,): whole rows at once, not three numbers."""
    return (light.reshape(len(light), -1) * by).reshape(light.shape)


def _shaken(light: NDArray[np.float32], rng: np.random.Generator) -> NDArray[np.float32]:
    side = int(rng.integers(3, 7)) | 1
    kernel = np.zeros((side, side), np.float32)
    angle = rng.uniform(0, np.pi)
    reach = side // 2
    for share in np.linspace(-1, 1, 4 * side):
        x, y = reach + share * reach * np.cos(angle), reach + share * reach * np.sin(angle)
        kernel[round(y), round(x)] += 1
    return np.asarray(cv2.filter2D(light, -1, kernel / kernel.sum()))
