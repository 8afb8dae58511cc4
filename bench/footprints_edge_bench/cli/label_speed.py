"""``fp-bench label-speed``."""

import typer

from footprints_edge.cli.exit_codes import explained


def label_speed_command() -> None:
    """Measure the speed of training labels.

    Labels of 256x448 with 10 neighbouring frames are computed on one core and compared with a plain
    loop over pixels. Set OMP_NUM_THREADS=1, so that numpy uses one core too. Prints JSON.

    Exit codes: 0 done, 2 usage error.
    """
    with explained("bench"):
        from footprints_edge_bench.latency.label_speed import measure_label_speed

        typer.echo(measure_label_speed().as_json(), nl=False)
