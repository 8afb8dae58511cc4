"""Depth that other frames look through."""

import numpy as np

from footprints_edge.geometry.camera import Intrinsics
from footprints_edge_bench.ground_truth.false_depth import seen_through
from footprints_edge_models.mapping.floor_map import DepthFrame

CAMERA = Intrinsics(60, 60, 39.5, 29.5)
SPECK = (25, 10)


def frame(right_m, speck_m=0.0):
    """A wall 4 m ahead and a box 2 m ahead, from a place to the right, with a speck before it."""
    pose = np.eye(4)
    pose[0, 3] = right_m
    depth_m = np.full((60, 80), 4.0, np.float32)
    column = np.arange(80)
    shown = np.abs((column - CAMERA.cx) * 2 / CAMERA.fx + right_m) < 0.33
    depth_m[20:40, shown] = 2.0
    if speck_m:
        depth_m[SPECK] = speck_m
    return DepthFrame(depth_m, CAMERA, pose)


def test_a_speck_that_nobody_else_sees_is_refuted_and_a_box_is_not():
    others = [frame(each) for each in (-0.3, -0.2, 0.2, 0.3)]
    refuted = seen_through(frame(0, speck_m=2.0), others)
    assert refuted[SPECK]
    assert refuted.sum() == 1


def test_two_frames_are_not_enough_and_unknown_depth_says_nothing():
    silent = DepthFrame(np.zeros((60, 80), np.float32), CAMERA, np.eye(4))
    others = [frame(-0.2), frame(0.2), silent, silent]
    assert not seen_through(frame(0, speck_m=2.0), others).any()
