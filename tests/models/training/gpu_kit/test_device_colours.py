"""Colours on the device: ranges, and JPEG against a JPEG library."""

import cv2
import numpy as np
import pytest
import torch

from footprints_edge_models.training.gpu_kit.device_colours import blur, jitter, jpeg


def picture(size=(64, 96)):
    rows, columns = np.mgrid[: size[0], : size[1]]
    waves = [np.sin(rows / 5) + np.cos(columns / 7), np.sin(columns / 4), np.cos(rows / 9)]
    noise = np.random.default_rng(0).normal(0, 8, (*size, 3))
    return (128 + 50 * np.stack(waves, -1) + noise).clip(0, 255).astype(np.uint8)


def on_device(rgb):
    return torch.from_numpy(rgb).permute(2, 0, 1)[None].float() / 255


@pytest.mark.parametrize("quality", [30, 60, 90])
def test_jpeg_leaves_what_a_jpeg_library_leaves(quality):
    rgb = picture()
    flags = [cv2.IMWRITE_JPEG_QUALITY, quality]
    data = cv2.imencode(".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), flags)[1]
    known = cv2.cvtColor(cv2.imdecode(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB).astype(float)
    ours = jpeg(on_device(rgb), torch.tensor([float(quality)]))[0].permute(1, 2, 0).numpy() * 255
    loss = np.abs(known - rgb).mean()
    assert np.abs(ours - known).mean() < 0.35 * loss
    assert np.abs(ours - rgb).mean() == pytest.approx(loss, rel=0.15)


def test_each_picture_is_blurred_by_its_own_kernel():
    image = on_device(picture()).repeat(2, 1, 1, 1)
    kernels = torch.zeros(2, 7, 7)
    kernels[0, 3, 3] = 1
    kernels[1] = 1 / 49
    blurred = blur(image, kernels)
    assert torch.allclose(blurred[0], image[0], atol=1e-6)
    known = cv2.blur(image[1].permute(1, 2, 0).numpy(), (7, 7), borderType=cv2.BORDER_REFLECT_101)
    assert np.abs(blurred[1].permute(1, 2, 0).numpy() - known).max() < 1e-5


def test_jittered_pictures_are_pictures_and_the_seed_decides_them():
    image = on_device(picture()).repeat(24, 1, 1, 1)
    once, again = (
        jitter(image.clone(), np.random.default_rng(5), torch.Generator().manual_seed(1))
        for _ in range(2)
    )
    assert torch.equal(once, again)
    assert once.shape == image.shape
    assert once.min() >= 0
    assert once.max() <= 1
    assert ((once * 255).round() / 255 - once).abs().max() < 1e-6
    changes = (once - image).abs().mean(dim=(1, 2, 3))
    assert changes.min() > 0
    assert 0.02 < changes.mean() < 0.25
    assert (once.std(dim=1).mean(dim=(1, 2)) < 0.01).any()  # some are grey
