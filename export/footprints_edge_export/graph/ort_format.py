"""onnxruntime's own file format, for its builds without an ONNX parser."""

import subprocess
import sys
from pathlib import Path

from footprints_edge_export.errors import VerificationError


def to_ort_format(model: Path, name: str) -> Path:
    """Convert a model file with onnxruntime's own tool.

    The tool applies the optimisations that hold on every 64-bit processor, and none for one CPU
    only: the result also runs on x86 and in WebAssembly.

    Args:
        model: ``.onnx`` file. The results are written beside it: ``.ort``, and
            ``.operators.config``, the list of operators that a reduced build of onnxruntime needs
            (``--include_ops_by_config``).
        name: final name of the ``.ort`` file, for the list.

    Returns:
        Path of the ``.ort`` file.

    Raises:
        VerificationError: the tool fails.
    """
    tool = "onnxruntime.tools.convert_onnx_models_to_ort"
    options = ["--optimization_style", "Fixed", "--target_platform", "arm"]
    done = subprocess.run(
        [sys.executable, "-m", tool, *options, str(model)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["it says nothing"])[-1]
        raise VerificationError(f"{name} cannot be made; onnxruntime's converter says: {last}")
    operators = model.with_suffix(".required_operators.config").read_text().splitlines()
    listed = [f"# Operators of {name}", *(line for line in operators if line[:1] not in ("#", ""))]
    ort = model.with_suffix(".ort")
    operators_path(ort).write_text("\n".join(listed) + "\n")
    return ort


def operators_path(ort: Path) -> Path:
    """Path of the list of operators of an ``.ort`` file."""
    return ort.with_suffix(".operators.config")
