"""A box and a room of voxels, in closed form, for the tests of the benchmark's baselines."""

import numpy as np

from footprints_edge_bench.geometry.boxes import Box
from footprints_edge_bench.geometry.voxels import CLASSES, VoxelGrid

FLOOR, CHAIR, WALL = CLASSES.index("floor"), CLASSES.index("chair"), CLASSES.index("wall")


def in_camera(box_low, box_high, camera_to_world, turn_deg=0.0):
    """The box of the world between two corners, turned about its upright axis, in camera axes."""
    low, high = np.array(box_low, float), np.array(box_high, float)
    turn = np.radians(turn_deg)
    # length along the world's x, down, depth along y
    axes = np.array([[np.cos(turn), np.sin(turn), 0], [0, 0, -1], [-np.sin(turn), np.cos(turn), 0]])
    to_camera = np.linalg.inv(camera_to_world)
    centre = to_camera[:3, :3] @ (low + high) / 2 + to_camera[:3, 3]
    size = (high - low)[[0, 2, 1]]
    return Box(centre, size, to_camera[:3, :3] @ axes.T)


def voxel_room(camera_to_world):
    """A floor of x -2 to 2, y 0 to 5 whose top is at z = 0; a chair above x 0 to 0.8, y 2 to 3;
    a wall across, at y = 1."""
    voxel_m = 0.1
    labels = np.zeros((40, 50, 22), np.uint8)
    labels[:, :, 0] = FLOOR
    labels[20:28, 20:30, 5] = CHAIR
    labels[:, 10, 1:] = WALL
    return VoxelGrid(labels, np.array([-2, 0, -voxel_m]), voxel_m, camera_to_world)
