"""The command ``fp-bench``: one file per subcommand."""

import typer

from footprints_edge.cli.common_options import HELP, VersionOption
from footprints_edge_bench.cli.accuracy import accuracy_command
from footprints_edge_bench.cli.confidence import confidence_command
from footprints_edge_bench.cli.flicker import flicker_command
from footprints_edge_bench.cli.frame import frame_command
from footprints_edge_bench.cli.known_pose import known_pose_command
from footprints_edge_bench.cli.label_speed import label_speed_command
from footprints_edge_bench.cli.latency import latency_command
from footprints_edge_bench.cli.obstacles import obstacles_command
from footprints_edge_bench.cli.occupancy import occupancy_command
from footprints_edge_bench.cli.passes import passes_command
from footprints_edge_bench.cli.planning import planning_command
from footprints_edge_bench.cli.reduced_decoding import reduced_decoding_command
from footprints_edge_bench.cli.roofline import roofline_command
from footprints_edge_bench.cli.table import table_command
from footprints_edge_bench.cli.trade_off import trade_off_command
from footprints_edge_bench.cli.video import video_command

app = typer.Typer(
    name="fp-bench",
    help="Measure the accuracy and speed of footprints-edge models.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=HELP,
)


@app.callback()
def _root(_version: VersionOption = False) -> None:
    """Measure the accuracy and speed of footprints-edge models."""


app.command("accuracy")(accuracy_command)
app.command("planning")(planning_command)
app.command("occupancy")(occupancy_command)
app.command("obstacles")(obstacles_command)
app.command("known-pose")(known_pose_command)
app.command("confidence")(confidence_command)
app.command("flicker")(flicker_command)
app.command("video")(video_command)
app.command("latency")(latency_command)
app.command("frame")(frame_command)
app.command("table")(table_command)
app.command("trade-off")(trade_off_command)
app.command("roofline")(roofline_command)
app.command("passes")(passes_command)
app.command("reduced-decoding")(reduced_decoding_command)
app.command("label-speed")(label_speed_command)


def main() -> None:
    """Entry point of ``fp-bench``."""
    app()
