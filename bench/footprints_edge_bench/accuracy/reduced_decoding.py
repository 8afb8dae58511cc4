"""Effect on the maps of decoding a large JPEG at reduced size, and of JPEG compression itself.

Each photo is enlarged to 12 million pixels and saved as a JPEG. The network then sees it in three
ways: decoded and resized as in the runtime; decoded at full size and resized; and resized without
JPEG compression. The last two differ only by the compression.
"""

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import FILTERS, preprocess
from footprints_edge.model import Model
from footprints_edge_bench.foundation.markdown import markdown_table

if TYPE_CHECKING:
    from footprints_edge_export.verification.compare import Difference

PIXELS = 12e6
_QUALITY = 92


@dataclass(frozen=True)
class DecodingEffect:
    """Differences that were found on one photo.

    Attributes:
        photo: name of the file.
        image_size: (H, W) of the enlarged photo.
        decoded_size: (H, W) that the runtime decoded it at.
        of_decoding: maps with reduced decoding against maps of the full JPEG.
        of_jpeg: maps of the full JPEG against maps without compression.
    """

    photo: str
    image_size: Size
    decoded_size: Size
    of_decoding: "Difference"
    of_jpeg: "Difference"


def decoding_effect(model: Model, photo: Path, pixels: float = PIXELS) -> DecodingEffect:
    """Compares the maps of one photo.

    Args:
        model: the model to run.
        photo: any image file.
        pixels: number of pixels to enlarge it to.

    Raises:
        ImageError: the photo cannot be read.
    """
    from footprints_edge_export.verification.compare import compare_maps

    given = Image.fromarray(decode(photo).rgb)
    scale = math.sqrt(pixels / (given.width * given.height))
    large = given.resize(
        (round(given.width * scale), round(given.height * scale)), Image.Resampling.BICUBIC
    )
    file = io.BytesIO()
    large.save(file, "JPEG", quality=_QUALITY)
    size = model.input_size((large.height, large.width))

    def resized(rgb: Rgb) -> Rgb:
        image = Image.fromarray(rgb).resize(size[::-1], FILTERS[model.metadata.resize])
        return np.asarray(image)[None]

    picture = model.decode(file.getvalue())
    reduced, full, uncompressed = (
        model.engine.run(image)
        for image in (
            preprocess(picture.pixels, size, model.metadata.resize),
            resized(picture.rgb),
            resized(np.asarray(large)),
        )
    )
    height, width, _ = picture.pixels.shape
    return DecodingEffect(
        photo.name,
        picture.size,
        (height, width),
        compare_maps([(full, reduced)]),
        compare_maps([(uncompressed, full)]),
    )


def as_markdown(effects: Sequence[DecodingEffect]) -> str:
    """A table with two rows per photo."""
    columns = ["photo", "effect of", "visible ground IoU", "ground IoU", "depth", "ground depth"]
    rows = [
        [
            f"{each.photo}, {each.image_size[1]} x {each.image_size[0]}",
            cause,
            f"{found.visible_ground_iou:.4f}",
            f"{found.ground_iou:.4f}",
            f"{found.visible_depth_abs_rel:.2%}",
            f"{found.ground_depth_abs_rel:.2%}",
        ]
        for each in effects
        for cause, found in (
            (f"decoding at {each.decoded_size[1]} x {each.decoded_size[0]}", each.of_decoding),
            (f"the JPEG, quality {_QUALITY}", each.of_jpeg),
        )
    ]
    return markdown_table(columns, rows, left=2) + "\n"
