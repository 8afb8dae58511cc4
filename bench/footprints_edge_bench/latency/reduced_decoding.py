"""What decoding a large JPEG at a reduced size does to the maps, beside what the JPEG itself did.

    python -m footprints_edge_bench.reduced_decoding PHOTO...

Each photo is enlarged to 12 million pixels and saved as a JPEG; three pictures of it then go
through the network: as the runtime decodes and resizes it; decoded in full and resized at once; and
as it was before it became a JPEG, resized at once. The last two differ by nothing but the JPEG.
"""

import argparse
import io
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image

from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import FILTERS, preprocess
from footprints_edge.model import Model, load
from footprints_edge_bench.latency.tables import table

if TYPE_CHECKING:
    from footprints_edge_export.verification.compare import Difference

PIXELS = 12e6
_QUALITY = 92


@dataclass(frozen=True)
class Effect:
    """What was found of a photo.

    Attributes:
        photo: its file's name.
        image_size: (H, W) that it was enlarged to.
        decoded_size: (H, W) that it was decoded at.
        of_decoding: maps of the runtime's picture against those of the whole JPEG.
        of_jpeg: maps of the whole JPEG against those of the picture before.
    """

    photo: str
    image_size: Size
    decoded_size: Size
    of_decoding: "Difference"
    of_jpeg: "Difference"


def effect(model: Model, photo: Path, pixels: float = PIXELS) -> Effect:
    """Compares the maps of one photo.

    Args:
        model: whose maps.
        photo: any picture.
        pixels: how many to enlarge it to.
    """
    from footprints_edge_export.verification.compare import compare_maps

    given = Image.fromarray(decode(photo).rgb)
    times = math.sqrt(pixels / (given.width * given.height))
    large = given.resize(
        (round(given.width * times), round(given.height * times)), Image.Resampling.BICUBIC
    )
    file = io.BytesIO()
    large.save(file, "JPEG", quality=_QUALITY)
    size = model.input_size((large.height, large.width))

    def at_once(rgb: Rgb) -> Rgb:
        resized = Image.fromarray(rgb).resize(size[::-1], FILTERS[model.metadata.resize])
        return np.asarray(resized)[None]

    picture = model.decode(file.getvalue())
    reduced, whole, before = (
        model.engine.run(image)
        for image in (
            preprocess(picture.pixels, size, model.metadata.resize),
            at_once(picture.rgb),
            at_once(np.asarray(large)),
        )
    )
    height, width, _ = picture.pixels.shape
    return Effect(
        photo.name,
        picture.size,
        (height, width),
        compare_maps([(whole, reduced)]),
        compare_maps([(before, whole)]),
    )


def as_markdown(effects: Sequence[Effect]) -> str:
    """A table, two rows a photo."""
    columns = ["photo", "effect of", "visible ground IoU", "ground IoU", "depth", "ground depth"]
    rows = [
        [
            f"{each.photo}, {each.image_size[1]} x {each.image_size[0]}",
            what,
            f"{found.visible_ground_iou:.4f}",
            f"{found.ground_iou:.4f}",
            f"{found.visible_depth_abs_rel:.2%}",
            f"{found.ground_depth_abs_rel:.2%}",
        ]
        for each in effects
        for what, found in (
            (f"decoding at {each.decoded_size[1]} x {each.decoded_size[0]}", each.of_decoding),
            (f"the JPEG, quality {_QUALITY}", each.of_jpeg),
        )
    ]
    return table(columns, rows, left=2) + "\n"


def main() -> None:
    """Print the effects on the photos named, as Markdown."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("photos", nargs="+", type=Path)
    parser.add_argument("--model", default=None, help="file or name; the default model")
    options = parser.parse_args()
    model = load(options.model)
    sys.stdout.write(as_markdown([effect(model, photo) for photo in options.photos]))


if __name__ == "__main__":
    main()
