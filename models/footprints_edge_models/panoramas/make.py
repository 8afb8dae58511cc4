"""Makes a folder of views of labelled panoramas."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from footprints_edge_models.asset_files.credit_files import write_credits_file
from footprints_edge_models.panoramas.files import begin, view_name, write_manifest, write_view
from footprints_edge_models.panoramas.labels import (
    PanoramaError,
    find_panoramas,
    read_panoramas,
)
from footprints_edge_models.panoramas.views import draw_view


@dataclass(frozen=True)
class PanoramaReport:
    """What became of the panoramas of a folder.

    Attributes:
        panoramas: names of those with views.
        views: how many there are in all.
        skipped: why others have none, one message each.
    """

    panoramas: tuple[str, ...]
    views: int
    skipped: tuple[str, ...]


def make_views(
    assets: Path, folder: Path, count: int, seed: int, progress: Callable[[], object]
) -> PanoramaReport:
    """Cuts views out of every labelled panorama; writes them and the panoramas' credits.

    Args:
        assets: folder of labelled panoramas, or one that holds it.
        folder: of the views; those of the same names are replaced.
        count: views of each panorama.
        seed: decides their cameras, together with the panoramas' names.
        progress: called after each panorama.

    Raises:
        PanoramaError: there are no labelled panoramas, or none can be used.
    """
    source = find_panoramas(assets)
    begin(folder)
    used, entries, skipped = [], [], []
    for panorama in read_panoramas(source):
        if isinstance(panorama, PanoramaError):
            skipped.append(str(panorama))
        else:
            for number in range(count):
                view = draw_view(panorama, number, seed)
                entries.append(write_view(folder, view_name(panorama.name, number), view))
            used.append(panorama)
        progress()
    if not used:
        reasons = "; ".join(skipped) or "no panorama has labels"
        raise PanoramaError(f"{assets}: no panorama can be used: {reasons}")
    write_credits_file(folder, [panorama.credit for panorama in used])
    write_manifest(folder, seed, entries)
    names = tuple(panorama.name for panorama in used)
    return PanoramaReport(names, len(entries), tuple(skipped))
