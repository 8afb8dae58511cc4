"""The default model against the paper's network in PyTorch, network alone, one interleaved run.

    python -m footprints_edge_bench.against_reference --threads 2

Both see the same bytes at the same size and take turns in random order, so that whatever else
the machine does hits both alike. Latency does not depend on weights: the reference's are random.
"""

import argparse
import json
import statistics
import sys

import numpy as np

from footprints_edge.foundation.cores import usable_cores
from footprints_edge.model import load
from footprints_edge_bench.latency.timing import interleaved_ms

SIZE = (256, 448)


def main() -> None:
    """Print medians, minima and their ratio as JSON."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", maxsplit=1)[0])
    parser.add_argument("--model", default=None, help="file or name; the default model")
    parser.add_argument("--threads", type=int, default=usable_cores())
    parser.add_argument("--trials", type=int, default=50)
    options = parser.parse_args()

    import torch

    from footprints_edge_models.networks.reference import ReferenceNetwork

    torch.set_num_threads(options.threads)
    image = np.random.default_rng(0).integers(0, 256, (1, *SIZE, 3), dtype=np.uint8)
    model = load(options.model, threads=options.threads)
    reference = ReferenceNetwork().eval()
    tensor = torch.from_numpy(image).permute(0, 3, 1, 2).float() / 255

    def run_reference() -> object:
        with torch.inference_mode():
            return reference(tensor)

    times_ms = interleaved_ms(
        {"model": lambda: model.engine.run(image), "reference in torch": run_reference},
        options.trials,
    )
    ours, theirs = times_ms["model"], times_ms["reference in torch"]
    result = {
        "size": SIZE,
        "threads": options.threads,
        "trials": options.trials,
        "model": f"{model.name} {model.metadata.precision}",
        "model_ms": {"median": statistics.median(ours), "min": min(ours)},
        "reference_torch_ms": {"median": statistics.median(theirs), "min": min(theirs)},
        "ratio_of_medians": statistics.median(theirs) / statistics.median(ours),
        "ratio_of_minima": min(theirs) / min(ours),
        "torch": torch.__version__,
    }
    sys.stdout.write(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
