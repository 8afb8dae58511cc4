"""``fp-bench confidence``."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import OneModel, class_ids
from footprints_edge_bench.cli.progress import progress_bar


def confidence_command(
    data: Annotated[list[Path], typer.Argument(help="Datasets with ground truth.")],
    *,
    without: Annotated[
        list[Path],
        typer.Option(
            "--without",
            help="Folder that pictures without ground are taken from: a dataset, textures, "
            "panoramas, or pictures; repeatable.",
        ),
    ],
    model: OneModel = None,
    walkable: Annotated[
        str, typer.Option(metavar="IDS", help="Class ids of ground in labelled photos.")
    ] = "",
    most: Annotated[
        int, typer.Option(min=4, help="Pictures from each dataset, evenly spread.")
    ] = 160,
    refit: Annotated[
        bool,
        typer.Option(
            "--refit", help="Fit the curves to half of the pictures and write confidence.json."
        ),
    ] = False,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Draw the diagram to this PNG.")
    ] = None,
) -> None:
    """Score confidences and find pictures without ground.

    Of each dataset the first half of the pictures is for --refit, the second is scored. Prints
    tables as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.atomic_write import write_atomically
        from footprints_edge.maps.confidence import CURVES_FILE, curves
        from footprints_edge.model import load
        from footprints_edge_bench.ground_truth.datasets import ReadingOptions
        from footprints_edge_bench.navigation.confidence import (
            as_markdown,
            collect,
            draw,
            fit,
            score,
        )

        reading = ReadingOptions(walkable=class_ids(walkable, "--walkable"))
        with progress_bar(most * (len(data) + len(without)), "picture") as progress:
            examples = collect(load(model), data, without, reading, most, progress)
        found = fit(examples) if refit else curves()
        if refit:
            write_atomically(CURVES_FILE, found.to_json().encode())
        scores = score(examples, found)
        if output is not None:
            draw(scores, output)
        typer.echo(as_markdown(examples, found, scores), nl=False)
