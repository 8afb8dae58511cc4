"""A program: one runtime's steps of a frame, each timed when its name is read from standard input.

`whole_frame` runs it in a process for each runtime. It uses what every version of the runtime has.
"""

import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np
from PIL import Image

import footprints_edge as fp


def main(frame: str, phone: str, threads: str, model: str) -> None:
    """Answers each line with milliseconds: those of the step, and of the resize in it or 0.

    Args:
        frame: Picture that `predict` takes as an array.
        phone: JPEG that it takes as bytes.
        threads: Threads of the network.
        model: Model file or name; empty for the bundled model.
    """
    loaded = fp.load(model or None, threads=int(threads))
    array, jpeg = np.asarray(Image.open(frame)), Path(phone).read_bytes()
    high, wide = loaded.input_size(array.shape[:2])
    ready = np.asarray(Image.open(frame).resize((wide, high)))[None]
    engine = vars(loaded).get("engine") or vars(loaded)["session"]  # of older versions
    plain = loaded.predict(array, flatten=False)
    image = Image.open(phone)
    least = loaded.input_size((image.height, image.width))

    def draft() -> None:
        image = Image.open(phone)
        image.draft("RGB", (2 * least[1], 2 * least[0]))
        image.load()

    def result() -> None:
        found = replace(plain).flattened()  # a new one: masks are kept
        _ = found.visible_ground, found.hidden_ground, found.ground_depth_m

    def metres() -> float:
        found = loaded.predict(jpeg)
        _ = found.ground_depth_m
        return found.timings_ms["preprocess"]

    steps: dict[str, Callable[[], float | None]] = {
        "network": lambda: engine.run(ready) is None,
        "array": lambda: loaded.predict(array).timings_ms["preprocess"],
        "result": result,
        "draft": draft,
        "jpeg": metres,
    }
    for line in sys.stdin:
        step = steps[line.strip()]
        step()  # caches are warm, and other processes' threads asleep
        start_s = perf_counter()
        resize_ms = step()
        took_ms = 1000 * (perf_counter() - start_s)
        sys.stdout.write(f"{took_ms} {resize_ms or 0}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # the benchmark that asks says that it was stopped
    main(*sys.argv[1:])
