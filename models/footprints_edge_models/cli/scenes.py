"""``fp-train scenes``: synthetic scenes."""

import json
import time
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge_models.cli.options import Engine, JobEngine, Jobs, size_of

if TYPE_CHECKING:
    from footprints_edge.parallel.job import ItemOutcome
    from footprints_edge_models.scenes.make import ScenePictures
    from footprints_edge_models.scenes.storage.files import SceneSettings

VIEWS_WITH_ASSETS = 4
"""Views of a scene of 3D models: loading and placing these takes longer than a picture."""


class Purpose(StrEnum):
    """What synthetic scenes are for."""

    TRAIN = "train"
    TEST = "test"


def scenes(
    output: Annotated[
        Path, typer.Argument(help="Folder of the scenes; an unfinished folder is resumed.")
    ],
    count: Annotated[int, typer.Option(min=0, help="Number of pictures in the folder at the end.")],
    seed: Annotated[
        int, typer.Option(min=0, help="Random seed of the set; each split has its own scenes.")
    ] = 0,
    size: Annotated[
        str,
        typer.Option(
            metavar="HxW", help="Size of landscape pictures; a third are portrait or square."
        ),
    ] = "256x448",
    split: Annotated[
        Purpose, typer.Option(help="test adds boxes and voxels, and shares no texture with train.")
    ] = Purpose.TRAIN,
    textures: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True, file_okay=False, help="Folder of photos for textures; repeat for more."
        ),
    ] = None,
    assets: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True,
            help="Pack made by fp-train assets, or folders of assets; repeat for more folders.",
        ),
    ] = None,
    views: Annotated[
        int | None,
        typer.Option(
            min=1,
            show_default=f"{VIEWS_WITH_ASSETS} with --assets, else 1",
            help="Pictures of each scene; a scene where not so many good ones are found has fewer.",
        ),
    ] = None,
    jobs: Jobs = None,
    engine: Engine = JobEngine.LOCAL,
    preview: Annotated[
        Path | None, typer.Option(help="Write a contact sheet of the folder, a PNG.")
    ] = None,
    beside: Annotated[
        list[Path] | None,
        typer.Option(
            exists=True,
            file_okay=False,
            help="Folder of photos to show beside the pictures on the contact sheet, and to "
            "compare them with in numbers; repeat for more.",
        ),
    ] = None,
) -> None:
    """Make rooms and streets with exact visible and hidden ground; print a summary as JSON.

    Exit codes: 0 all done, 1 some scenes failed, 2 usage.
    """
    with explained("train"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_models.scenes.storage.beside_photos import write_beside_photos
        from footprints_edge_models.scenes.storage.files import SceneSettings
        from footprints_edge_models.scenes.storage.preview import write_preview

        if beside and preview is None:
            raise typer.BadParameter("--beside needs --preview: it decides what is on the sheet")
        if views is None:
            views = VIEWS_WITH_ASSETS if assets else 1
        on_ray = engine is JobEngine.RAY
        if on_ray:
            with explained("ray"):
                import ray  # noqa: F401  (says now what is missing)
        settings = SceneSettings(split.value, seed, size_of(size), views=views)
        processes = jobs or usable_cores()
        start = time.perf_counter()
        pack = _pack(output, assets or [])
        outcomes = _make(output, settings, textures or [], count, processes, pack, on_ray=on_ray)
        seconds = time.perf_counter() - start
        looks = None
        if preview is not None and beside:
            looks = write_beside_photos(output, beside, preview)
        elif preview is not None:
            write_preview(output, preview)
        written = [size for o in outcomes if o.result is not None for size in o.result.made]
        kept = sum(o.result.kept for o in outcomes if o.result is not None)
        failed = sum(outcome.state == "failed" for outcome in outcomes)
        summary = {
            "scenes": str(output),
            "split": split.value,
            "made": len(written),
            "kept": kept,
            "failed": failed,
            "views": views,
            "processes": processes,
            "pictures_per_second_and_process": round(len(written) / seconds / processes, 2),
            "bytes_per_picture": round(sum(written) / len(written)) if written else None,
            **({"made_photos_distance": looks} if looks else {}),
        }
        typer.echo(json.dumps(summary))
        if failed:
            complain(f"{failed} of {len(outcomes)} scenes failed; run it again to retry them")
            raise typer.Exit(SOME_FAILED)


def _pack(output: Path, assets: list[Path]) -> Path | None:
    """The pack of the assets; folders are packed into the output folder, once."""
    if not assets:
        return None
    if len(assets) == 1 and assets[0].is_file():
        return assets[0]
    from footprints_edge_models.asset_files.pack import pack_assets

    pack = output / "assets.zip"
    if pack.is_file():
        complain(f"using {pack}; delete it to pack {', '.join(map(str, assets))} again")
    else:
        complain(f"packing the assets of {', '.join(map(str, assets))} into {pack}")
        report = pack_assets(assets, pack)
        if report.skipped:
            complain(f"{len(report.skipped)} assets cannot be used; fp-train assets says why")
    return pack


def _make(
    output: Path,
    settings: "SceneSettings",
    textures: list[Path],
    count: int,
    processes: int,
    pack: Path | None,
    *,
    on_ray: bool,
) -> list["ItemOutcome[int, ScenePictures]"]:
    """Makes the scenes behind a progress bar; every scene's outcome."""
    from tqdm import tqdm

    from footprints_edge_models.scenes.make import make_scenes

    outcomes: list[ItemOutcome[int, ScenePictures]] = []
    scenes = -(-count // settings.views)
    with tqdm(total=scenes, unit="scene", disable=None) as bar:

        def report(outcome: "ItemOutcome[int, ScenePictures]") -> None:
            outcomes.append(outcome)
            if outcome.state == "failed":
                bar.clear()
                complain(f"scene {outcome.item} failed: {outcome.reason}")
            bar.update()

        make_scenes(
            output, settings, textures, count, processes, report, assets=pack, on_ray=on_ray
        )
    return outcomes
