"""onnxruntime's own file format: what its builds without an ONNX parser read."""

import subprocess
import sys
from pathlib import Path

from footprints_edge_export.errors import VerificationError


def to_ort_format(model: Path, name: str) -> tuple[bytes, str]:
    """Convert with onnxruntime's own tool.

    The optimisations of any 64-bit processor are done beforehand; none is for one CPU only, and
    the result runs on x86 and in WebAssembly too.

    Args:
        model: ``.onnx`` file; its folder takes the intermediate files.
        name: of the file that it becomes, for the list.

    Returns:
        The ``.ort`` file, and the list of its operators that a reduced build of onnxruntime takes
        (``--include_ops_by_config``).

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
    return model.with_suffix(".ort").read_bytes(), "\n".join(listed) + "\n"
