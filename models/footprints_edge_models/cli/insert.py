"""``fp-train insert``: 3D models on the floors of photos."""

import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge_models.cli.options import Jobs, Seed


def insert(
    photos: Annotated[
        Path,
        typer.Argument(
            exists=True, file_okay=False, help="Labelled photos, as fp-train photos writes them."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of the dataset; it is resumed.")
    ],
    assets: Annotated[
        Path, typer.Option(exists=True, dir_okay=False, help="Pack made by fp-train assets.")
    ],
    variants: Annotated[int, typer.Option(min=1, help="Pictures of each photo to try.")] = 2,
    model: Annotated[
        str | None,
        typer.Option(help="Model that finds the ground plane: a file or a name."),
    ] = None,
    seed: Seed = 0,
    jobs: Jobs = None,
) -> None:
    """Put 3D models on the floors of photos: hidden ground with exact labels; print a summary.

    Photos without a plain floor, or without a free place on it, are left out.

    Exit codes: 0 all done, 1 some pictures failed, 2 usage, 3 problem with the model.
    """
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge.model import load
        from footprints_edge.parallel.job import ItemOutcome
        from footprints_edge_models.asset_files.pack import AssetPack
        from footprints_edge_models.insertion.make import InsertJob, insert_models
        from footprints_edge_models.scenes.make import scene_library

        pictures = _trained_on(photos)
        load(model, threads=1)  # what is wrong with it is wrong for every picture
        job = InsertJob(pictures, output, scene_library("train", [], assets), model, seed)
        counts: Counter[str] = Counter()
        with tqdm(total=variants * len(pictures), unit="picture", disable=None) as bar:

            def report(outcome: ItemOutcome[int, str]) -> None:
                left_out = outcome.state == "done" and outcome.result
                counts["left_out" if left_out else outcome.state] += 1
                why = outcome.reason if outcome.state == "failed" else outcome.result
                if why:
                    what = "failed" if outcome.state == "failed" else "left out"
                    complain(f"{what}: {pictures[outcome.item % len(pictures)]}: {why}")
                bar.update()

            insert_models(job, AssetPack(assets), variants, jobs or usable_cores(), report)
        summary = {"folder": str(output), "made": counts["done"], "kept": counts["kept"]}
        summary |= {"left_out": counts["left_out"], "failed": counts["failed"]}
        typer.echo(json.dumps(summary))
        if counts["failed"]:
            raise typer.Exit(SOME_FAILED)


@dataclass(frozen=True)
class _Photo:
    """A photo under its name in the split of its dataset."""

    name: str
    path: Path


def _trained_on(photos: Path) -> tuple[Path, ...]:
    """The photos of a dataset that training does not hold out."""
    from footprints_edge_models.data.readers.pictures import list_pictures
    from footprints_edge_models.data.splits import SPLITS, train_on_all

    title = photos.resolve().name
    named = [_Photo(f"{title}/{path.stem}", path) for path in list_pictures(photos / "images")]
    return tuple(photo.path for photo in SPLITS.get(title, train_on_all)(named)[0])
