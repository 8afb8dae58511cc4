"""The installed wheel alone: import, help, one prediction, and nothing heavy on the way."""

import subprocess
import sys
from pathlib import Path


def main() -> None:
    """Fail loudly if any part of the slim product is missing or drags something in."""
    import footprints_edge as fp

    prediction = fp.load().predict(sys.argv[1])
    assert prediction.ground.any(), "no ground found in the example picture"
    loaded = {"torch", "onnx", "cv2", "typer", "matplotlib"} & set(sys.modules)
    assert not loaded, f"a prediction imported {loaded}"
    folder = Path(sys.executable).parent
    for command in ("fp-infer", "fp-models", "fp-export", "fp-train", "fp-bench"):
        subprocess.run([folder / command, "--help"], check=True, stdout=subprocess.DEVNULL)
    written = subprocess.run(
        [folder / "fp-infer", sys.argv[1], "-o", "out"], check=True, stdout=subprocess.PIPE
    )
    assert Path(written.stdout.decode().strip()).is_file(), written.stdout


if __name__ == "__main__":
    main()
