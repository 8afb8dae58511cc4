"""A large JPEG that is decoded at a reduced size gives the maps that all of it gives."""

from pathlib import Path

import pytest

from footprints_edge.model import load
from footprints_edge_bench.accuracy.reduced_decoding import as_markdown, decoding_effect

ROOM = Path(__file__).resolve().parents[3] / "examples" / "room.jpg"


@pytest.fixture(scope="module")
def effects(shared):
    model = load(threads=1)
    photos = [ROOM, *sorted((shared / "data" / "photos").glob("*.jpg"))]
    assert len(photos) >= 3
    return [decoding_effect(model, photo) for photo in photos]


def mean_loss(differences):
    """Mean of 1 - IoU of both masks, and of both depths' relative errors."""
    masks = [1 - d.visible_ground_iou for d in differences] + [
        1 - d.ground_iou for d in differences
    ]
    depths = [d.visible_depth_abs_rel for d in differences]
    return sum(masks) / len(masks), sum(depths) / len(depths)


def test_it_costs_no_more_than_twice_what_the_jpeg_did(effects):
    for each in effects:
        assert each.image_size[0] * each.image_size[1] == pytest.approx(12e6, rel=0.01)
        assert each.decoded_size[0] * each.decoded_size[1] < 1e6
    mask_loss, depth_loss = mean_loss([each.of_decoding for each in effects])
    jpeg_mask_loss, jpeg_depth_loss = mean_loss([each.of_jpeg for each in effects])
    assert mask_loss <= 2 * jpeg_mask_loss
    assert depth_loss <= 2 * jpeg_depth_loss


def test_the_table_has_both_effects_of_every_photo(effects):
    lines = as_markdown(effects).splitlines()
    assert len(lines) == 2 + 2 * len(effects)
    assert "decoding at 11" in lines[2] and "the JPEG" in lines[3]
