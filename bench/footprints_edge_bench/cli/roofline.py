"""``fp-bench roofline``."""

from typing import Annotated

import typer

from footprints_edge.cli.exit_codes import explained
from footprints_edge_bench.cli.options import (
    EDGE_CHECKPOINT,
    CacheFolder,
    EdgeCheckpoint,
    FurtherModels,
    JsonFile,
    Only,
    ReferenceSizes,
    Threads,
    network_size,
)


def roofline_command(
    *,
    output: JsonFile = None,
    only: Only = None,
    models: FurtherModels = None,
    sizes: ReferenceSizes = None,
    threads: Threads = None,
    trials: Annotated[int, typer.Option(min=1, help="Timed frames per row.")] = 10,
    edge_checkpoint: EdgeCheckpoint = EDGE_CHECKPOINT,
    cache: CacheFolder = None,
) -> None:
    """Compare networks with the peak of the machine.

    Shows, by operator, the share of the peak that is reached. Prints tables as Markdown.

    Exit codes: 0 done, 2 usage error, 3 model problem.
    """
    with explained("bench"):
        from footprints_edge.foundation.cores import usable_cores
        from footprints_edge_bench.latency.backends import select_backends
        from footprints_edge_bench.latency.machine import machine
        from footprints_edge_bench.latency.roofline import roofline
        from footprints_edge_bench.model_files.model_cache import ModelCache, default_folder

        backends = select_backends(
            only or (), models or (), [network_size(text) for text in sizes or ()]
        )
        found = roofline(
            [backend for backend in backends if backend.engine == "onnxruntime"],
            ModelCache(cache or default_folder(), edge_checkpoint),
            machine(),
            threads=threads or usable_cores(),
            trials=trials,
        )
        if output is not None:
            output.write_text(found.as_json(), encoding="utf-8")
        typer.echo(found.as_markdown(), nl=False)
