"""What a camera and a file do to colours, for a batch on the device.

As ``augmentation.jitter_colours`` and ``degradation``, as often as these.

Random numbers for a picture are drawn on the host, those for a pixel on the device.
"""

import math

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray

from footprints_edge_models.data.degradation import (
    BLURRED,
    COMPRESSED,
    JPEG_QUALITY,
    NOISY,
    SHAKEN,
)

_REACH = 3
"""Blur kernels reach so many pixels to each side."""
_LUMA = (0.299, 0.587, 0.114)
_LUMA_STEPS = (
    *(16, 11, 10, 16, 24, 40, 51, 61),
    *(12, 12, 14, 19, 26, 58, 60, 55),
    *(14, 13, 16, 24, 40, 57, 69, 56),
    *(14, 17, 22, 29, 51, 87, 80, 62),
    *(18, 22, 37, 56, 68, 109, 103, 77),
    *(24, 35, 55, 64, 81, 104, 113, 92),
    *(49, 64, 78, 87, 103, 121, 120, 101),
    *(72, 92, 95, 98, 112, 100, 103, 99),
)
"""Quantisation of luminance at quality 50 (JPEG standard, ITU-T T.81, table K.1)."""
_CHROMA_STEPS = (
    *(17, 18, 24, 47, 99, 99, 99, 99),
    *(18, 21, 26, 66, 99, 99, 99, 99),
    *(24, 26, 56, 99, 99, 99, 99, 99),
    *(47, 66, 99, 99, 99, 99, 99, 99),
    *(99, 99, 99, 99, 99, 99, 99, 99) * 4,
)
"""Likewise of chrominance (table K.2)."""


def jitter(
    image: torch.Tensor, rng: np.random.Generator, generator: torch.Generator
) -> torch.Tensor:
    """Jitters the colours of pictures (B, 3, h, w) in [0, 1], sides multiples of 16.

    Args:
        image: The pictures.
        rng: Draws what is the same for all pixels of a picture.
        generator: Draws noise, on the pictures' device.
    """
    count = len(image)
    image = _toned(image, rng)
    blurred = np.flatnonzero(rng.random(count) < BLURRED + SHAKEN)
    if len(blurred):
        chosen = _on(image.device, blurred)
        kernels = np.stack([_blur_kernel(rng) for _ in blurred]).astype(np.float32)
        image[chosen] = blur(image[chosen], _on(image.device, kernels))
    noisy = rng.random(count) < NOISY
    levels = _on(image.device, (noisy * rng.uniform(2, 8, count) / 255).astype(np.float32))
    grain = torch.randn(
        (count, 1, *image.shape[2:]), generator=generator, device=image.device, dtype=image.dtype
    )
    image = image.addcmul(grain, levels.reshape(-1, 1, 1, 1)).clamp(0, 1)
    packed = np.flatnonzero(rng.random(count) < COMPRESSED)
    if len(packed):
        chosen = _on(image.device, packed)
        qualities = rng.uniform(*JPEG_QUALITY, len(packed)).astype(np.float32)
        image[chosen] = jpeg(image[chosen], _on(image.device, qualities))
    return (image * 255).round() / 255


def _on(device: torch.device, array: NDArray[np.generic]) -> torch.Tensor:
    return torch.from_numpy(array).to(device, non_blocking=True)


def _toned(image: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
    """Gamma, contrast, brightness; greyscale, or saturation and hue."""
    count = len(image)
    gamma, contrast = np.exp(rng.normal(0, 0.25, count)), 1 + rng.normal(0, 0.2, count)
    bright = rng.normal(0, 0.08, count)
    dice = rng.random(count)
    saturation = np.where(dice < 0.65, np.maximum(1 + rng.normal(0, 0.25, count), 0), 1)
    saturation = np.where(dice < 0.12, 0, saturation)
    hue = np.where(dice < 0.65, rng.normal(0, np.radians(12), count), 0)
    # Colour is what remains without luminance. It is turned about the grey axis and scaled.
    cos, sin = np.cos(hue)[:, None, None], np.sin(hue)[:, None, None]
    cross = np.array([[0, -1, 1], [1, 0, -1], [-1, 1, 0]]) / math.sqrt(3)
    turn = cos * np.eye(3) + sin * cross + (1 - cos) * np.full((3, 3), 1 / 3)
    luma = np.tile(np.array(_LUMA), (3, 1))
    colour = luma + saturation[:, None, None] * (turn @ (np.eye(3) - luma))
    facts = np.concatenate(
        [colour.reshape(count, 9), gamma[:, None], contrast[:, None], bright[:, None]], axis=1
    )
    on = _on(image.device, facts.astype(np.float32)).reshape(count, 12, 1, 1, 1)
    image = image.clamp(min=1e-4) ** on[:, 9]
    image = ((image - 0.5) * on[:, 10] + 0.5 + on[:, 11]).clamp(0, 1)
    red, green, blue = image[:, 0:1], image[:, 1:2], image[:, 2:3]
    channels = [
        on[:, 3 * k] * red + on[:, 3 * k + 1] * green + on[:, 3 * k + 2] * blue for k in range(3)
    ]
    return torch.cat(channels, dim=1).clamp(0, 1)


def _blur_kernel(rng: np.random.Generator) -> NDArray[np.float64]:
    """Out of focus, or shaken: (7, 7), sums to one."""
    side = 2 * _REACH + 1
    place = np.arange(side) - _REACH
    if rng.random() < BLURRED / (BLURRED + SHAKEN):
        line = np.exp(-(place**2) / (2 * rng.uniform(0.5, 1.2) ** 2))
        kernel = np.outer(line, line)
    else:
        angle, reach = rng.uniform(0, np.pi), rng.uniform(1, _REACH)
        kernel = np.zeros((side, side))
        for share in np.linspace(-1, 1, 4 * side):
            x, y = reach * share * np.cos(angle), reach * share * np.sin(angle)
            kernel += np.outer(np.maximum(1 - abs(place - y), 0), np.maximum(1 - abs(place - x), 0))
    return np.asarray(kernel / kernel.sum())


def blur(image: torch.Tensor, kernels: torch.Tensor) -> torch.Tensor:
    """Pictures (B, 3, h, w), each by its own kernel (B, k, k); mirrored at their edges."""
    count, channels, height, width = image.shape
    reach = kernels.shape[-1] // 2
    padded = F.pad(image, (reach, reach, reach, reach), mode="reflect")
    weight = kernels.repeat_interleave(channels, dim=0).unsqueeze(1)
    flat = padded.reshape(1, count * channels, *padded.shape[2:])
    blurred = F.conv2d(flat, weight, groups=count * channels)
    return blurred.reshape(count, channels, height, width)


def jpeg(image: torch.Tensor, qualities: torch.Tensor) -> torch.Tensor:
    """What JPEG at these qualities leaves of pictures (B, 3, h, w) in [0, 1]; colour at half size.

    Sides are multiples of 16.
    """
    quality = qualities.reshape(-1, 1, 1, 1)
    scale = torch.where(quality < 50, 50 / quality, 2 - quality / 50)
    red, green, blue = image[:, 0:1], image[:, 1:2], image[:, 2:3]
    luma = _LUMA[0] * red + _LUMA[1] * green + _LUMA[2] * blue
    colour = torch.cat([(blue - luma) / 1.772, (red - luma) / 1.402], dim=1)
    colour = F.avg_pool2d(colour, 2)
    luma = _quantised((luma - 0.5) * 255, _LUMA_STEPS, scale) / 255 + 0.5
    colour = _quantised(colour * 255, _CHROMA_STEPS, scale) / 255
    colour = F.interpolate(colour, scale_factor=2, mode="bilinear", align_corners=False)
    red = luma + 1.402 * colour[:, 1:2]
    blue = luma + 1.772 * colour[:, 0:1]
    green = (luma - _LUMA[0] * red - _LUMA[2] * blue) / _LUMA[1]
    return torch.cat([red, green, blue], dim=1).clamp(0, 1)


def _quantised(plane: torch.Tensor, steps: tuple[int, ...], scale: torch.Tensor) -> torch.Tensor:
    """Planes (B, C, h, w), their blocks of 8x8 rounded in the cosine transform."""
    count, channels, height, width = plane.shape
    k = torch.arange(8, dtype=plane.dtype, device=plane.device)
    basis = torch.cos((2 * k[None] + 1) * k[:, None] * (math.pi / 16)) / 2
    basis[0] /= math.sqrt(2)
    table = torch.tensor(steps, dtype=plane.dtype).to(plane.device, non_blocking=True)
    step = (table.reshape(8, 8).T * scale).round().clamp(1, 255)  # (B, 1, 8, 8)
    step = step.reshape(count, 1, 1, 1, 8, 8)
    blocks = plane.reshape(count, channels, height // 8, 8, width // 8, 8).transpose(3, 4)
    # Only products with one matrix on the right: each is one large product, not many tiny ones.
    waves = (blocks @ basis.T).transpose(-1, -2) @ basis.T  # transposed
    waves = (waves / step).round() * step
    blocks = (waves @ basis).transpose(-1, -2) @ basis
    return blocks.transpose(3, 4).reshape(count, channels, height, width)
