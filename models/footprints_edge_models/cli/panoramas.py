"""``fp-train panoramas``: perspective views of panoramas with hand-drawn ground."""

import json
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge_models.cli.options import Seed


def panoramas(
    assets: Annotated[
        Path,
        typer.Argument(
            exists=True,
            file_okay=False,
            help="Folder of panoramas (index.json, labels/*.json), or of assets that holds it.",
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of the views; they are made anew.")
    ],
    views: Annotated[int, typer.Option(min=1, help="Number of views of each panorama.")] = 32,
    seed: Seed = 0,
) -> None:
    """Cut perspective views with hand-drawn ground out of panoramas; print a summary as JSON.

    Exit codes: 0 all done, 1 some panoramas cannot be used, 2 usage.
    """
    with explained("train"):
        from tqdm import tqdm

        from footprints_edge_models.asset_files.pictures import HELD_OUT_PANORAMAS
        from footprints_edge_models.panoramas.contact_sheet import write_contact_sheet
        from footprints_edge_models.panoramas.make import make_views

        with tqdm(unit="panorama", disable=None) as bar:
            report = make_views(assets, output, views, seed, bar.update)
        for reason in report.skipped:
            complain(f"skipped: {reason}")
        summary = {
            "folder": str(output),
            "panoramas": len(report.panoramas),
            "held_out": sorted(HELD_OUT_PANORAMAS & set(report.panoramas)),
            "views": report.views,
            "skipped": len(report.skipped),
            "contact_sheet": str(write_contact_sheet(output)),
        }
        typer.echo(json.dumps(summary))
        if report.skipped:
            raise typer.Exit(SOME_FAILED)
