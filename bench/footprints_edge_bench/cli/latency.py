"""``fp-bench latency``."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import SOME_FAILED, complain, explained
from footprints_edge_bench.cli.options import (
    EDGE_CHECKPOINT,
    CacheFolder,
    EdgeCheckpoint,
    FurtherModels,
    Only,
    ReferenceSizes,
    Threads,
    network_size,
)
from footprints_edge_bench.cli.progress import progress_bar


class SpinningOption(StrEnum):
    """Values of ``engines.backend.Spinning``, which is imported late."""

    SHIPPED = "shipped"
    ON = "on"
    OFF = "off"


def latency_command(
    *,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of latency.md, .json and .png.")
    ] = Path("latency"),
    threads: Threads = None,
    spinning: Annotated[
        SpinningOption,
        typer.Option(
            help="When onnxruntime's threads spin: within a frame, as in the runtime package "
            "(shipped), also between frames (on), or never (off)."
        ),
    ] = SpinningOption.SHIPPED,
    trials: Annotated[int, typer.Option(min=2, help="Timed frames per row.")] = 50,
    only: Only = None,
    models: FurtherModels = None,
    sizes: ReferenceSizes = None,
    photos: Annotated[
        Path | None,
        typer.Option(help="Folder of photos to compare maps on.  [default: synthetic photos]"),
    ] = None,
    processes: Annotated[
        int, typer.Option(min=0, help="Fresh processes for the cold start; 0 leaves it out.")
    ] = 7,
    network_only: Annotated[
        bool, typer.Option("--network-only", help="Leave out whole frames and the cold start.")
    ] = False,
    edge_checkpoint: EdgeCheckpoint = EDGE_CHECKPOINT,
    cache: CacheFolder = None,
) -> None:
    """Time networks in onnxruntime and other engines.

    Frames run one at a time. The tables, printed as Markdown, also show the accuracy of each row.

    Exit codes: 0 done, even if other engines cannot run; 1 a row of onnxruntime, or every row,
    cannot run; 2 usage error; 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.engines.backend import BackendSetting, Spinning
        from footprints_edge_bench.latency.backends import select_backends
        from footprints_edge_bench.latency.comparison_photos import photos_by_size
        from footprints_edge_bench.latency.run import run_latency
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        backends = select_backends(
            only or (), models or (), [network_size(text) for text in sizes or ()]
        )
        setting = BackendSetting(
            ModelCache(cache or default_folder(), edge_checkpoint),
            threads or usable_cores(),
            Spinning(spinning.value),
        )
        compared = None if photos is None else photos_by_size(photos, backends)
        output.mkdir(parents=True, exist_ok=True)
        with progress_bar(trials * len(backends), "frame") as progress:
            found = run_latency(
                backends,
                setting,
                trials,
                models=models or (),
                photos=compared,
                processes=processes,
                network_only=network_only,
                progress=progress,
            )
        typer.echo(found.write(output), nl=False)
        for row in found.networks.rows:
            if row.reason is not None:
                complain(f"Not run: {row.name}: {row.reason}")
        if found.networks.failed():
            raise typer.Exit(SOME_FAILED)
