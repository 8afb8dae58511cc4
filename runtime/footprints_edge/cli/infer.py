"""The options of `fp-infer`, for typer; `run_infer` is what it does."""

from pathlib import Path
from typing import Annotated

import typer

from footprints_edge.cli.common_options import HELP, VersionOption
from footprints_edge.cli.exit_codes import OptionError
from footprints_edge.cli.run_infer import run_infer

__all__ = ["app", "infer", "main"]

app = typer.Typer(context_settings=HELP, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def infer(
    images: Annotated[
        list[str],
        typer.Argument(
            help="Pictures, folders, or - for standard input; videos, rtsp://…, camera:0; bags "
            "of ROS."
        ),
    ],
    *,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            help="Folder for the results, or for one bag the bag to write (.mcap, .bag). Default: "
            "beside each picture.",
        ),
    ] = None,
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--format",
            help="Output formats, separated by commas: overlay (default), npz, png16, json, ply, "
            "topdown, topdown_npz, topdown_ply, topdown_picture. For videos: overlay, json. For "
            "bags: grid, scan, points, overlay; default: all.",
        ),
    ] = None,
    model: Annotated[
        str | None, typer.Option(help="Model file, or a name from fp-models list.")
    ] = None,
    engine: Annotated[
        str,
        typer.Option(
            help="onnxruntime, openvino, a plug-in: onnxruntime-ep-…; or ray, for pictures: "
            "onnxruntime on the cluster of RAY_ADDRESS, else on this machine."
        ),
    ] = "onnxruntime",
    providers: Annotated[
        list[str] | None,
        typer.Option(
            "--provider",
            help="Execution provider of onnxruntime, such as CUDAExecutionProvider; several in "
            "order of preference. Default: the CPU.",
        ),
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Number of threads. Default: one per usable core."),
    ] = None,
    threshold: Annotated[
        float, typer.Option(min=0, max=1, help="Probability above which a pixel counts as ground.")
    ] = 0.5,
    flatten: Annotated[
        bool,
        typer.Option(
            " /--no-flatten", help="Keep the network's depth of flat ground, off its plane."
        ),
    ] = True,
    fx: Annotated[float | None, typer.Option(help="Focal length along x, in pixels.")] = None,
    fy: Annotated[float | None, typer.Option(help="Focal length along y, in pixels.")] = None,
    cx: Annotated[
        float | None, typer.Option(help="Principal point along x. Default: the centre.")
    ] = None,
    cy: Annotated[
        float | None, typer.Option(help="Principal point along y. Default: the centre.")
    ] = None,
    hfov: Annotated[
        float | None,
        typer.Option(help="Horizontal field of view in degrees, instead of --fx and --fy."),
    ] = None,
    camera_file: Annotated[
        Path | None,
        typer.Option(
            "--camera",
            metavar="FILE",
            help="Calibration file (YAML of ROS camera_calibration or OpenCV), with distortion: "
            "pictures are rectified first. Instead of --fx, --fy and --hfov.",
        ),
    ] = None,
    camera_height: Annotated[
        float | None,
        typer.Option(help="Height of the camera above the ground in metres, if known."),
    ] = None,
    pitch: Annotated[
        float | None, typer.Option(help="Downward pitch of the camera in degrees, if known.")
    ] = None,
    roll: Annotated[
        float | None,
        typer.Option(help="Roll of the camera in degrees, right side down, if known."),
    ] = None,
    robot_height: Annotated[
        float,
        typer.Option(
            help="Height of the robot in metres: what stands between a step (0.15 m) and this is "
            "an obstacle.",
        ),
    ] = 1.2,
    path: Annotated[
        tuple[str, str] | None,
        typer.Option(
            metavar="X0,Y0 X1,Y1",
            help="Plan a path between two pixels of the picture and draw it to .path.png.",
        ),
    ] = None,
    margin: Annotated[
        float, typer.Option(min=0, help="Distance in metres that the path keeps from obstacles.")
    ] = 0.0,
    every: Annotated[int, typer.Option(min=1, help="Process every Nth frame of a video.")] = 1,
    max_fps: Annotated[
        float | None, typer.Option(help="Process at most this many frames per second of a video.")
    ] = None,
    raw: Annotated[
        str | None,
        typer.Option(
            metavar="WxH[@FPS]",
            help="Read raw RGB frames of this size (width first) from standard input: "
            "ffmpeg … | fp-infer - --raw …",
        ),
    ] = None,
    smooth: Annotated[
        bool, typer.Option("--smooth", help="Smooth the maps of a video over time.")
    ] = False,
    bev: Annotated[
        bool,
        typer.Option("--bev", "--panel", help="Add a bird's-eye view beside the overlay."),
    ] = False,
    topic: Annotated[
        str | None, typer.Option(help="Topic of a bag's pictures, if it has several.")
    ] = None,
    ground_frame: Annotated[
        str, typer.Option(help="Bags: name of the ground's frame, below the camera.")
    ] = "camera_footprint",
    hidden: Annotated[
        str,
        typer.Option(help="Bags: what hidden ground is in grids: cost, unknown or free."),
    ] = "cost",
    recursive: Annotated[
        bool, typer.Option("--recursive", help="Search sub-folders, too.")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace existing results.")
    ] = False,
    quiet: Annotated[
        bool, typer.Option("-q", "--quiet", help="Print results and errors only.")
    ] = False,
    verbose: Annotated[
        bool, typer.Option("-v", "--verbose", help="Print one line per image.")
    ] = False,
    _version: VersionOption = False,
) -> None:
    """Find the walkable ground in pictures and videos, seen and hidden, and its distance in metres.

    Prints the files written. Exit codes: 0 all done, 1 some inputs failed,
    2 usage error, 3 model problem.
    """
    given = {name: value for name, value in locals().items() if name != "_version"}
    try:
        run_infer(**given)
    except OptionError as error:
        raise typer.BadParameter(str(error)) from error


def main() -> None:
    """Runs `fp-infer` by typer; see `start`."""
    app()


if __name__ == "__main__":
    from footprints_edge.cli.start import start

    start("footprints_edge.cli.infer")
