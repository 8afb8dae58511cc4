"""Fills a folder with photos that models were put into; finished ones are kept."""

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from footprints_edge.foundation.atomic_write import write_atomically
from footprints_edge.inputs.images import decode
from footprints_edge.inputs.preprocessing import resized
from footprints_edge.model import load
from footprints_edge.parallel.job import ReportOutcome
from footprints_edge.parallel.processes import run_in_processes
from footprints_edge.parallel.serial import run_serially
from footprints_edge_models.asset_files.asset import AssetError
from footprints_edge_models.asset_files.credit_files import write_credits_file
from footprints_edge_models.asset_files.dataset_credits import photo_credits
from footprints_edge_models.asset_files.pack import AssetPack
from footprints_edge_models.insertion.composite import Composite, compose
from footprints_edge_models.insertion.photo_floor import InsertionError, find_floor
from footprints_edge_models.insertion.standing import place_things
from footprints_edge_models.sample import nearest, within
from footprints_edge_models.scenes.assets.materials import Palette
from footprints_edge_models.scenes.assets.textures.library import TextureLibrary
from footprints_edge_models.scenes.assets.things import Thing

SETTINGS = "settings.json"
_QUALITIES = (75, 95)


@dataclass(frozen=True)
class InsertJob:
    """Variants of the photos of a folder, by number: photo number + variant x number of photos.

    Attributes:
        photos: pictures with label pictures, as ``fp-train photos`` writes them.
        folder: where the pictures go.
        library: models and textures.
        model: name or file of the model that finds the ground plane; None for the default one.
        seed: decides every picture.
        shares_cores: whether other processes work on it as well, one for every core.
    """

    photos: tuple[Path, ...]
    folder: Path
    library: TextureLibrary
    model: str | None
    seed: int
    shares_cores: bool = False

    def finished(self, number: int) -> str | None:
        """Nothing to say of a picture that is there."""
        return "" if self._file("images", number, ".jpg").is_file() else None

    def start(self) -> Callable[[int], str]:
        """The function that makes a picture; returns why there is none, else nothing."""
        if self.shares_cores:
            cv2.setNumThreads(1)
        model = load(self.model, threads=1)

        def make(number: int) -> str:
            rng = np.random.default_rng((self.seed, number))
            path = self.photos[number % len(self.photos)]
            image = decode(path).rgb
            ids = np.asarray(Image.open(path.parent.parent / "labels" / f"{path.stem}.png"))
            size = within((image.shape[0], image.shape[1]))
            if size != image.shape[:2]:
                image, ids = resized(image, size), nearest(ids, size)
            try:
                floor = find_floor(image, ids, model)
                things = place_things(floor, Palette(self.library, rng))
                if not things:
                    raise InsertionError("no free place on its floor")
                made = compose(floor, things, self.library, rng)
            except InsertionError as error:
                return str(error)
            self._write(number, made, things, int(rng.integers(*_QUALITIES)))
            return ""

        return make

    def _file(self, part: str, number: int, suffix: str) -> Path:
        photo = self.photos[number % len(self.photos)].stem
        return self.folder / part / f"{photo}_{number // len(self.photos)}{suffix}"

    def _write(self, number: int, made: Composite, things: Iterable[Thing], quality: int) -> None:
        facts = [{"label": thing.label, "assets": _assets_of(thing)} for thing in things]
        label_picture = cv2.imencode(".png", made.labels.encoded())[1].tobytes()
        bgr = cv2.cvtColor(made.image, cv2.COLOR_RGB2BGR)
        photo = cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()
        write_atomically(self._file("things", number, ".json"), json.dumps(facts).encode())
        write_atomically(self._file("labels", number, ".png"), label_picture)
        write_atomically(self._file("images", number, ".jpg"), photo)


def _assets_of(thing: Thing) -> list[str]:
    """Keys of the model that a thing is, and of the photographed textures on it."""
    pictures = {part.material.texture.picture for part in thing.parts}
    return sorted({thing.asset, *pictures} - {""})


def insert_models(
    job: InsertJob,
    pack: AssetPack,
    variants: int,
    processes: int,
    report: ReportOutcome[int, str],
) -> None:
    """Makes the pictures that are not there yet; one that fails is reported, and others are made.

    Args:
        job: what to make.
        pack: of the job's library.
        variants: pictures of each photo that are tried.
        processes: number of processes; with one, the pictures are made in this process.
        report: called with the outcome of every picture.

    Raises:
        AssetError: the folder was begun with other assets, or another model or seed.
    """
    job = replace(job, shares_cores=processes > 1)
    _begin(job, pack)
    numbers = range(variants * len(job.photos))
    try:
        if processes == 1:
            run_serially(job, numbers, report)
        else:
            run_in_processes(job, numbers, report, processes=processes, run_length=16)
    finally:  # an interrupted folder is credited, too
        _write_credits(job, pack)


def _begin(job: InsertJob, pack: AssetPack) -> None:
    """Begins a folder, or checks that it was begun with the same settings."""
    path = job.folder / SETTINGS
    settings = {"assets": pack.fingerprint, "model": job.model or "", "seed": job.seed}
    if path.is_file() and (begun := path.read_text(encoding="utf-8")) != json.dumps(settings):
        raise AssetError(
            f"{job.folder}: begun with {begun}, not with {json.dumps(settings)}; go on with the "
            "same, or give another folder"
        )
    for part in ("images", "labels", "things"):
        (job.folder / part).mkdir(parents=True, exist_ok=True)
    write_atomically(path, json.dumps(settings).encode())


def _write_credits(job: InsertJob, pack: AssetPack) -> None:
    """Writes ``credits.json``: whom to credit for photos, models and textures."""
    used: set[str] = set()
    for path in sorted((job.folder / "things").glob("*.json")):
        try:
            for thing in json.loads(path.read_text(encoding="utf-8")):
                used.update(thing["assets"])
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise AssetError(
                f"{path}: no readable list of things ({error}); delete it and its "
                "picture, and make them again"
            ) from error
    credits = {credit for photo in job.photos[:1] for credit in photo_credits(photo.parent.parent)}
    credits |= {entry.credit for entry in pack.entries if entry.key in used}
    write_credits_file(job.folder, credits)
