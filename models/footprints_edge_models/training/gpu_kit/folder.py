"""Builds a kit: a folder with all that a machine with PyTorch and OpenCV, but no network, lacks."""

import io
import logging
import lzma
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

import numpy as np
import torch

import footprints_edge
import footprints_edge_models
from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge_models.asset_files.asset import Credit
from footprints_edge_models.asset_files.credit_files import CREDITS, write_credits_file
from footprints_edge_models.asset_files.pack import AssetPack
from footprints_edge_models.data.errors import DatasetError
from footprints_edge_models.data.mixture import TrainingDataset
from footprints_edge_models.data.packed import datasets_in
from footprints_edge_models.networks.registry import NETWORKS
from footprints_edge_models.sample import Sample
from footprints_edge_models.training.beginning import initial_network
from footprints_edge_models.training.gpu_kit.kit_settings import (
    ASSETS,
    INITIAL_WEIGHTS,
    SETTINGS,
    SHARD,
    KitSettings,
)
from footprints_edge_models.training.gpu_kit.slim_pack import write_slim_pack
from footprints_edge_models.training.gpu_kit.stored_view import stored_view
from footprints_edge_models.training.gpu_kit.timed_run import SCENES, RunSize
from footprints_edge_models.training.gpu_kit.view_shard import ShardView, write_shard
from footprints_edge_models.training.recipe import Recipe
from footprints_edge_models.training.run_credits import credits_of_run
from footprints_edge_models.training.run_files import save_weights
from footprints_edge_models.training.schedule import ScheduleStage

logger = logging.getLogger(__name__)

CODE = "code.tar.xz"
RUNNER = "run.py"
FREE_DATASETS = ("hololens_office", "panoramas", SCENES)
"""What may go into weights that anybody may use."""
ASSETS_SHARE = 0.45
"""Most of a kit's bytes that the assets take."""
SCENES_SHARE = 0.1
"""Of the bytes for views, what scenes get that are there at once; the rest are photos."""
JPEG_QUALITY = 80
"""Of the views: training adds worse."""
HELD_OUT = 24
"""Held-out views of each data set."""
WHEELS = ("embreex",)
"""What such a machine lacks."""
_PYTHON = (
    *("--no-deps", "--only-binary=:all:", "--implementation", "cp", "--python-version", "3.12"),
    *("--platform", "manylinux_2_28_x86_64", "--platform", "manylinux_2_17_x86_64"),
)


def build_kit(
    folder: Path,
    data: Path,
    runner: Path,
    settings: KitSettings,
    *,
    assets: Path | None,
    init: Path | None,
    most_bytes: int,
    research: bool = False,
    wheels: Path | None = None,
) -> dict[str, int]:
    """Builds a kit in a folder; the bytes of its parts.

    Args:
        folder: Of the kit; what an earlier kit left there is replaced.
        data: Folder of data sets (see docs/data.md), or a packed one.
        runner: The program that unpacks the kit and trains.
        settings: Of the run; shares are filled in from the data sets.
        assets: Pack of ``fp-train assets``; None: scenes are made of boxes.
        init: Weights to begin with; None: the network's pretrained encoder.
        most_bytes: Of all files together.
        research: Also data whose licence allows research alone.
        wheels: Folder with the wheels that the machine lacks; None: pip downloads them.

    Raises:
        TrainingError: the settings are of no run.
        DatasetError: no data that may be used, or the parts do not fit.
        AssetError: the pack cannot be read.
        ModelError: the weights are not of the network.
    """
    # what the machine would refuse is refused here
    recipe = Recipe(
        (ScheduleStage.parse(f"{settings.size[0]}x{settings.size[1]}:1"),),
        seed=settings.seed,
        init=None if init is None else str(init),
        **settings.recipe,
    )
    if init is None and NETWORKS[recipe.network].pretrained is None:
        raise DatasetError(f"network {recipe.network}: no pretrained encoder; give initial weights")
    datasets = {name: each for name, each in datasets_in(data).items() if each.train}
    if not research:
        datasets = {name: each for name, each in datasets.items() if name in FREE_DATASETS}
    if not datasets:
        raise DatasetError(f"{data}: none of {', '.join(FREE_DATASETS)}; --research takes others")
    shares = {name: each.share for name, each in datasets.items()} | {
        SCENES: datasets[SCENES].share if SCENES in datasets else 0.9
    }
    settings = KitSettings(**vars(settings) | {"shares": shares})
    folder.mkdir(parents=True, exist_ok=True)
    for name in (CODE, f"{ASSETS}.xz", SHARD, RUNNER):
        (folder / name).unlink(missing_ok=True)
    shutil.copyfile(runner, folder / RUNNER)
    with tempfile.TemporaryDirectory() as scratch:
        write_credits_file(Path(scratch), _credits(datasets, init, assets))
        _write_code(folder / CODE, settings, recipe, wheels, Path(scratch))
    if assets is not None:
        most = min(int(ASSETS_SHARE * most_bytes), int(0.8 * _left(folder, most_bytes)))
        write_slim_pack(assets, folder / f"{ASSETS}.xz", most)
    views = _views(datasets, RunSize(settings.size).slot_px, 0.95 * _left(folder, most_bytes))
    write_shard(folder / SHARD, views, JPEG_QUALITY)
    _left(folder, most_bytes)
    return _sizes(folder)


def _credits(
    datasets: Mapping[str, TrainingDataset], init: Path | None, assets: Path | None
) -> list[Credit]:
    """Whom to credit for what a network may learn from the kit: of the pack, all of its split."""
    found = credits_of_run(datasets, None if init is None else str(init))
    entries = [] if assets is None else AssetPack(assets).entries
    return found + [entry.credit for entry in entries if entry.split == "train"]


def _sizes(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_size for path in sorted(folder.iterdir())}


def _left(folder: Path, most_bytes: int) -> int:
    """The bytes that are left.

    Raises:
        DatasetError: there are none.
    """
    sizes = _sizes(folder)
    if (total := sum(sizes.values())) > most_bytes:
        raise DatasetError(
            f"{folder}: the kit takes {total / 1e6:.1f} MB of {most_bytes / 1e6:.1f}: "
            + ", ".join(f"{name} {size / 1e6:.1f}" for name, size in sizes.items())
        )
    return most_bytes - total


def _write_code(
    path: Path, settings: KitSettings, recipe: Recipe, wheels: Path | None, scratch: Path
) -> None:
    """The packages' sources, libraries that the machine lacks, settings and initial weights."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w") as archive:

        def add(name: str, content: bytes) -> None:
            facts = tarfile.TarInfo(name)
            facts.size = len(content)
            archive.addfile(facts, io.BytesIO(content))

        for package in (footprints_edge, footprints_edge_models):
            root = Path(str(package.__file__)).parent
            for file in sorted(root.rglob("*")):
                unwanted = file.suffix in {".pyc", ".onnx", ".ort"} or not file.is_file()
                if not unwanted:
                    add(f"code/{root.name}/{file.relative_to(root).as_posix()}", file.read_bytes())
        for wheel in _wheels(wheels, scratch):
            with zipfile.ZipFile(wheel) as files:
                for name in files.namelist():
                    if not name.endswith("/"):
                        add(f"site/{name}", files.read(name))
        add(SETTINGS, settings.to_json().encode())
        add(CREDITS, (scratch / CREDITS).read_bytes())
        torch.manual_seed(recipe.seed)
        network, focal_px, _ = initial_network(recipe)
        weights = scratch / INITIAL_WEIGHTS
        save_weights(network, focal_px, weights)
        add(INITIAL_WEIGHTS, weights.read_bytes())
    write_atomically(path, lzma.compress(buffer.getvalue(), preset=6))


def _wheels(folder: Path | None, scratch: Path) -> Sequence[Path]:
    if folder is not None:
        return sorted(folder.glob("*.whl"))
    names = [f"{name}=={version(name)}" for name in WHEELS]
    command = [sys.executable, "-m", "pip", "download", "-q", *_PYTHON, "-d", str(scratch), *names]
    try:
        subprocess.run(command, check=True, capture_output=True, text=True)
    except subprocess.CalledProcessError as error:
        raise DatasetError(
            f"pip found no wheels of {', '.join(names)} for Python 3.12 on Linux: "
            f"{error.stderr.strip()[-300:]}; give a folder of wheels"
        ) from error
    return sorted(scratch.glob("*.whl"))


def _views(
    datasets: dict[str, TrainingDataset], most_px: int, most_bytes: float
) -> Iterator[ShardView]:
    """Views to train on, evenly out of each data set, as many as its part of the bytes holds."""
    held_out = {name: _evenly(each.held_out, HELD_OUT) for name, each in datasets.items()}
    view_bytes = {
        name: _mean_bytes([*held_out[name], *_evenly(each.train, 6)], most_px)
        for name, each in datasets.items()
    }
    needed = {name: view_bytes[name] * len(each.train) for name, each in datasets.items()}
    left = most_bytes - sum(view_bytes[name] * len(views) for name, views in held_out.items())
    # evenly among the photos; what one does not need goes to those after it
    order = sorted(datasets, key=lambda name: (name == SCENES, needed[name]))
    photos = sum(name != SCENES for name in order)
    scenes_bytes = (SCENES_SHARE if photos else 1.0) * left if SCENES in datasets else 0.0
    for place, name in enumerate(order):
        part = (left - scenes_bytes) / (photos - place) if name != SCENES else left
        chosen = _evenly(datasets[name].train, max(1, int(part / view_bytes[name])))
        left -= len(chosen) * view_bytes[name]
        logger.info(
            "%s: %d views, %d held out, %.0f kB each",
            *(name, len(chosen), len(held_out[name]), view_bytes[name] / 1e3),
        )
        for sample in held_out[name]:
            yield ShardView(stored_view(sample, most_px), name, "held out")
        for sample in chosen:
            yield ShardView(stored_view(sample, most_px), name, "train")


def _mean_bytes(samples: Sequence[Sample], most_px: int) -> float:
    with tempfile.TemporaryDirectory() as scratch:
        views = [ShardView(stored_view(sample, most_px), "", "train") for sample in samples]
        return write_shard(Path(scratch) / SHARD, views, JPEG_QUALITY)[""] / len(views)


def _evenly(samples: Sequence[Sample], most: int) -> list[Sample]:
    count = min(most, len(samples))
    return [samples[int(place)] for place in np.linspace(0, len(samples) - 1, count)]
