"""Scenes with closed forms, rendered by a ray caster of the tests' own."""

from dataclasses import dataclass

import numpy as np
import pytest
import torch

torch.set_num_threads(1)  # tiny tensors: threads cost more than they give


@dataclass(frozen=True)
class Box:
    """An axis-aligned box of the world."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]


@dataclass(frozen=True)
class Scene:
    """A floor z = 0 (z up) that reaches everywhere, and boxes on it or above it."""

    boxes: tuple[Box, ...] = ()

    def depth_m(self, camera_to_world, camera, size):
        """Depth along the optical axis, float32 (H, W), 0 where nothing is met."""
        height, width = size
        rows, columns = np.mgrid[:height, :width].astype(float)
        x, y = (columns - camera.cx) / camera.fx, (rows - camera.cy) / camera.fy
        directions = np.stack([x, y, np.ones_like(x)], -1) @ camera_to_world[:3, :3].T
        origin = camera_to_world[:3, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = np.where(directions[..., 2] < 0, -origin[2] / directions[..., 2], np.inf)
            for box in self.boxes:
                first = (np.array(box.low) - origin) / directions
                second = (np.array(box.high) - origin) / directions
                enter = np.minimum(first, second).max(axis=-1)
                leave = np.maximum(first, second).min(axis=-1)
                depth = np.where((enter < leave) & (enter > 0), np.minimum(depth, enter), depth)
        return np.where(np.isfinite(depth), depth, 0).astype(np.float32)


def look_at(eye, target):
    """Camera-to-world pose of an upright camera that looks from `eye` at `target`; z is up."""
    forward = np.subtract(target, eye).astype(float)
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    pose[:3, 3] = eye
    return pose


@pytest.fixture
def scene():
    """The class of made-up scenes."""
    return Scene


@pytest.fixture
def box():
    """The class of their boxes."""
    return Box


@pytest.fixture
def pose():
    """The function that makes camera-to-world poses."""
    return look_at


@pytest.fixture
def no_curves(monkeypatch):
    """Runs draw no curves: that takes most of the time of a run of few steps."""
    monkeypatch.setattr("footprints_edge_models.training.trainer.draw_curves", lambda _: None)
