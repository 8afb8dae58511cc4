"""What a frame costs beside what its network costs: arrays, phone photos, and folders of photos."""

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from time import perf_counter

import numpy as np
from PIL import Image

from footprints_edge.errors import FootprintsError
from footprints_edge.foundation.types import Size
from footprints_edge.inputs.preprocessing import enough_for, preprocess
from footprints_edge.model import Model
from footprints_edge_bench.foundation.markdown import markdown_table
from footprints_edge_bench.latency.end_to_end import PHONE
from footprints_edge_bench.latency.timing import Ratio, measure, ratio
from footprints_edge_bench.model_files.synthetic_photos import synthetic_jpeg

FRAME: Size = (720, 1280)
"""(H, W) of the array, and of the photos of the folder."""


class WholeFrameError(FootprintsError):
    """`fp-infer` failed on the folder."""


@dataclass(frozen=True)
class WholeFrame:
    """Medians, in ms, and ratios of one run in turns.

    Attributes:
        network_ms: the network alone, at the array's input size.
        array_ms: ``predict`` on an array.
        result_ms: masks, plane, flattened and masked depth of a prediction.
        draft_ms: decoding the phone's JPEG at the reduced size, alone.
        jpeg_ms: from the phone's JPEG to the ground's depth in metres.
        array_against_network: ratio of those two.
        jpeg_against_draft: ratio of those two.
        folder_fps: photos a second of ``fp-infer FOLDER --format json``, its start included.
        network_fps: frames a second of the network alone.
    """

    network_ms: float
    array_ms: float
    result_ms: float
    draft_ms: float
    jpeg_ms: float
    array_against_network: Ratio
    jpeg_against_draft: Ratio
    folder_fps: float
    network_fps: float

    def as_markdown(self) -> str:
        """A table."""
        array, jpeg = self.array_against_network, self.jpeg_against_draft
        rows = [
            ["network alone", f"{self.network_ms:.1f} ms"],
            [f"`predict` on an array of {FRAME[1]}x{FRAME[0]}", f"{self.array_ms:.1f} ms"],
            ["that / network", f"{array.value:.2f} ({array.low:.2f} to {array.high:.2f})"],
            ["masks, plane, flattened depth", f"{self.result_ms:.1f} ms"],
            [f"draft decode of a JPEG of {PHONE[1]}x{PHONE[0]}", f"{self.draft_ms:.1f} ms"],
            ["that JPEG to metres", f"{self.jpeg_ms:.1f} ms"],
            ["that / draft decode", f"{jpeg.value:.2f} ({jpeg.low:.2f} to {jpeg.high:.2f})"],
            ["`fp-infer` on a folder", f"{self.folder_fps:.1f} photos a second"],
            ["that / rate of the network", f"{self.folder_fps / self.network_fps:.2f}"],
        ]
        return markdown_table(["", "here"], rows) + "\n"


def whole_frame(model: Model, file: str, trials: int, photos: int) -> WholeFrame:
    """Measures a model.

    Args:
        model: the model, loaded with the threads to use.
        file: its file or registered name, for the command; empty for the bundled model.
        trials: timed frames of each kind.
        photos: photos in the folder; 0 leaves the folder out.

    Raises:
        WholeFrameError: `fp-infer` failed.
    """
    array = np.asarray(Image.open(BytesIO(synthetic_jpeg(FRAME))))
    phone = synthetic_jpeg(PHONE)
    size = model.input_size(FRAME)
    ready = preprocess(array, size, model.metadata.resize)
    plain = model.predict(array, flatten=False)

    def result() -> None:
        found = plain.at_size(plain.map_size).with_maps()  # a new one: masks are kept
        found = found.flattened()
        _ = found.visible_ground, found.hidden_ground, found.ground_depth_m

    def draft() -> None:
        image = Image.open(BytesIO(phone))
        height, width = enough_for(model.input_size(PHONE))
        image.draft("RGB", (width, height))
        image.load()

    timed = measure(
        {
            "network": lambda: model.engine.run(ready),
            "array": lambda: model.predict(array),
            "result": result,
            "draft": draft,
            "jpeg": lambda: model.predict(phone).ground_depth_m,
        },
        trials,
        settle_ms=0,
    )
    medians = {name: found.summary().p50_ms for name, found in timed.items()}
    return WholeFrame(
        network_ms=medians["network"],
        array_ms=medians["array"],
        result_ms=medians["result"],
        draft_ms=medians["draft"],
        jpeg_ms=medians["jpeg"],
        array_against_network=ratio(timed["array"].times_ms, timed["network"].times_ms),
        jpeg_against_draft=ratio(timed["jpeg"].times_ms, timed["draft"].times_ms),
        folder_fps=_folder_fps(file, model.engine.threads, photos) if photos else float("nan"),
        network_fps=1000 / medians["network"],
    )


def _folder_fps(file: str, threads: int, photos: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        jpeg = synthetic_jpeg(FRAME)
        for number in range(photos):
            Path(folder, f"{number}.jpg").write_bytes(jpeg)
        command = [sys.executable, "-m", "footprints_edge.cli.infer", folder, "-q"]
        command += ["--format", "json", "--threads", str(threads)]
        command += ["--model", file] if file else []
        start_s = perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        took_s = perf_counter() - start_s
    if done.returncode:
        raise WholeFrameError(f"fp-infer exited with code {done.returncode}: {done.stderr.strip()}")
    return photos / took_s
