"""Photos that the maps of backends are compared on."""

from collections.abc import Sequence
from pathlib import Path

from footprints_edge.errors import ImageError
from footprints_edge.foundation.types import Rgb, Size
from footprints_edge.inputs.image_files import image_files
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import enough_for, preprocess
from footprints_edge.outputs.writers import OUTPUT_ENDINGS
from footprints_edge_bench.engines.backend import Backend
from footprints_edge_bench.latency.backends import LatencyError
from footprints_edge_bench.model_files.synthetic_photos import synthetic_photo

SYNTHETIC_PHOTOS = 4
"""Number of synthetic photos, if no others are given."""

MOST_PHOTOS = 50
"""At most this many of the given photos are used."""


def synthetic_images(size: Size) -> list[Rgb]:
    """Synthetic photos at the size (H, W) of a network, uint8 (1, H, W, 3).

    None of them is used for calibration.
    """
    return [synthetic_photo(size, 1000 + seed)[None] for seed in range(SYNTHETIC_PHOTOS)]


def photos_by_size(folder: Path, backends: Sequence[Backend]) -> dict[Size, list[Rgb]]:
    """At most 50 photos of a folder, resized to the size of every backend.

    Raises:
        LatencyError: the folder holds no image that can be read.
        ImageError: the folder holds no image.
    """
    paths = image_files(folder, recursive=True, skip_endings=OUTPUT_ENDINGS)
    step = max(1, -(-len(paths) // MOST_PHOTOS))
    sizes = {backend.size for backend in backends}
    largest = enough_for((max(h for h, _ in sizes), max(w for _, w in sizes)))
    photos = []
    for path in paths[::step]:
        try:
            photos.append(decode(path, lambda _: largest).pixels)
        except ImageError:
            continue
    if not photos:
        raise LatencyError(
            f"{folder}: none of its {len(paths)} images can be read; give a folder of photos"
        )
    return {size: [preprocess(photo, size) for photo in photos] for size in sizes}
