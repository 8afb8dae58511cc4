"""Whom to credit for the assets that a folder of scenes shows."""

import logging
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import write_credits_file
from footprints_edge_models.asset_files.dataset_credits import photo_credits
from footprints_edge_models.asset_files.pack import AssetPack
from footprints_edge_models.bounded_files import read_arrays
from footprints_edge_models.scenes.storage.files import scene_names

logger = logging.getLogger(__name__)


def used_assets(folder: Path) -> Counter[str]:
    """Keys of the assets in the pictures of a folder, and in how many pictures each is used."""
    used: Counter[str] = Counter()
    for name in scene_names(folder):
        try:
            arrays = read_arrays(folder / "truth" / f"{name}.npz")
            if "assets" in arrays:
                used.update(map(str, arrays["assets"].ravel().tolist()))
        except (OSError, ValueError):  # it shows when it is read
            logger.warning("%s: scene %s is damaged; its assets are not credited", folder, name)
    return used


def write_credits(
    folder: Path, pack: AssetPack | None, textures: Sequence[Path] = ()
) -> list[Credit]:
    """Writes `credits.json`: title, author, licence and source of every asset and photo set used.

    Args:
        folder: Of the scenes.
        pack: The pack that they were made with.
        textures: Folders of photos whose crops are textures.

    Returns:
        The credits, by licence, author and title.
    """
    credits = {credit for photos in textures for credit in photo_credits(photos)}
    if pack is not None:
        used = used_assets(folder)
        credits |= {entry.credit for entry in pack.entries if entry.key in used}
    return write_credits_file(folder, credits)
