"""``fp-train photos``: photos labelled by a segmenter."""

import json
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained


def photos(
    folder: Annotated[
        Path, typer.Argument(exists=True, file_okay=False, help="Folder of the photos.")
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of the dataset; see docs/data.md.")
    ],
    source: Annotated[
        Path, typer.Option(help="A TFLite segmenter of ADE20K's 31 most frequent classes.")
    ],
) -> None:
    """Label the photos of FOLDER by a segmenter; print a summary as JSON.

    Photos that are narrow, or black and white, are left out; those that are labelled are kept.

    Exit codes: 0 all done, 1 some photos cannot be read, 2 usage, 3 problem with the segmenter.
    """
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge_models.data.photo_labels import label_photos
        from footprints_edge_models.segmenter import read_segmenter

        counts = {"photos": 0, "left_out": 0, "failed": 0}
        outcomes = label_photos(folder, output, read_segmenter(source))
        for outcome in tqdm(outcomes, unit="photo", disable=None):
            if outcome is None:
                counts["photos"] += 1
                continue
            what = "left_out" if isinstance(outcome, str) else "failed"
            counts[what] += 1
            complain(f"{what.replace('_', ' ')}: {outcome}")
        typer.echo(json.dumps({"folder": str(output), **counts}))
        if counts["failed"]:
            raise typer.Exit(SOME_FAILED)
