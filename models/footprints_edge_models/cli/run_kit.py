"""Unpacks the kit beside this file and trains: ``python run.py --minutes 9 --out RESULTS``.

``fp-train gpu-kit`` copies this file into every kit, as ``run.py``. Until the kit is unpacked,
nothing but Python's own library is there. Processes that make scenes run this file once more,
under another name: all of its work is in ``main``.
"""

import logging
import lzma
import shutil
import sys
import tarfile
import tempfile
import time
from pathlib import Path


def unpack(kit: Path, folder: Path) -> None:
    """Unpacks a kit's files into a folder, and makes the packages in them importable."""
    with tarfile.open(kit / "code.tar.xz") as archive:
        archive.extractall(folder, filter="data")
    assets = kit / "assets.zip.xz"
    if assets.is_file():
        with lzma.open(assets) as source, (folder / "assets.zip").open("wb") as target:
            shutil.copyfileobj(source, target, 1 << 20)
    shutil.copyfile(kit / "views.zip", folder / "views.zip")
    sys.path.insert(0, str(folder / "code"))
    sys.path.append(str(folder / "site"))  # a library that is installed comes first


def main() -> None:
    """Runs the command line."""
    started = time.monotonic()
    here = Path(__file__).resolve().parent
    with tempfile.TemporaryDirectory(prefix="fp-kit-") as scratch:
        unpacked = Path(scratch)
        unpack(here, unpacked)

        from typing import Annotated

        import typer

        app = typer.Typer(pretty_exceptions_enable=False, add_completion=False)

        @app.command()
        def run(
            out: Annotated[Path, typer.Option(help="Folder of the results.")],
            minutes: Annotated[float, typer.Option(min=0.1, help="Length of it all.")] = 9.0,
            device: Annotated[str, typer.Option(help="cpu, cuda, or auto.")] = "auto",
            batch: Annotated[int | None, typer.Option(min=1, help="Views a step.")] = None,
            processes: Annotated[
                int | None, typer.Option(help="Processes that make scenes; default: cores - 2.")
            ] = None,
            toy: Annotated[bool, typer.Option(help="Tiny: to see that all works.")] = False,
        ) -> None:
            """Train until the time is up; print the path of the weights."""
            from footprints_edge.cli.exit_codes import explained

            with explained("run"):
                from footprints_edge_models.cli.options import device_of
                from footprints_edge_models.training.gpu_kit.timed_run import run_kit

                out.mkdir(parents=True, exist_ok=True)
                logging.basicConfig(
                    level=logging.INFO,
                    format="%(asctime)s %(message)s",
                    handlers=[
                        logging.StreamHandler(),
                        logging.FileHandler(out / "log.txt", mode="w"),
                    ],
                )
                weights = run_kit(
                    unpacked,
                    out,
                    minutes,
                    device_of(device),
                    batch=batch,
                    processes=processes,
                    toy=toy,
                    started=started,
                )
                typer.echo(weights)

        app()


if __name__ == "__main__":
    main()
