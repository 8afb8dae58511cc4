"""``fp-train insert``: 3D models on the floors of photos."""

import json
from collections import Counter
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

    Exit codes: 0 all done, 1 some pictures failed, 2 usage.
    """
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge.parallel.job import ItemOutcome
        from footprints_edge_models.asset_files.pack import AssetPack
        from footprints_edge_models.data.readers.pictures import list_pictures
        from footprints_edge_models.insertion.make import (
            InsertJob,
            credit_insertions,
            insert_models,
        )
        from footprints_edge_models.scenes.make import scene_library

        pictures = tuple(list_pictures(photos / "images"))
        job = InsertJob(pictures, output, scene_library("train", [], assets), model, seed)
        counts: Counter[str] = Counter()
        with tqdm(total=variants * len(pictures), unit="picture", disable=None) as bar:

            def report(outcome: ItemOutcome[int, str]) -> None:
                left_out = outcome.state == "done" and outcome.result
                counts["left_out" if left_out else outcome.state] += 1
                if outcome.state == "failed":
                    complain(f"{pictures[outcome.item % len(pictures)]}: {outcome.reason}")
                bar.update()

            insert_models(job, variants, jobs or usable_cores(), report)
        credit_insertions(output, photos, AssetPack(assets))
        summary = {"folder": str(output), "made": counts["done"], "kept": counts["kept"]}
        summary |= {"left_out": counts["left_out"], "failed": counts["failed"]}
        typer.echo(json.dumps(summary))
        if counts["failed"]:
            raise typer.Exit(SOME_FAILED)
