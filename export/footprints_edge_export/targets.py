"""Targets of a model file: kinds of processors and runtimes, and what each needs."""

from dataclasses import dataclass

from onnxruntime.quantization import QuantType


@dataclass(frozen=True)
class ExportTarget:
    """What a kind of processor or runtime needs.

    Attributes:
        activations: uint8 or int8 activations in an int8 file.
        reduce_range: whether weights have 7 bits, where the CPU's multiply-add would saturate
            with 8.
        size: (H, W) that the input is fixed to if the caller names none; None leaves it free.
        plain_padding: whether reflecting Pads are written as Slice and Concat.
        ort_format: whether the file is also written in onnxruntime's own format, ``.ort``.
    """

    activations: QuantType
    reduce_range: bool = False
    size: tuple[int, int] | None = None
    plain_padding: bool = False
    ort_format: bool = False


TARGETS = {
    "x86-vnni": ExportTarget(QuantType.QUInt8),
    "x86-avx2": ExportTarget(QuantType.QUInt8, reduce_range=True),
    "arm64": ExportTarget(QuantType.QInt8),
    "web": ExportTarget(QuantType.QUInt8, plain_padding=True),
    "mobile": ExportTarget(QuantType.QInt8, size=(256, 448), plain_padding=True, ort_format=True),
}
"""x86 processors since about 2019 multiply uint8 by int8 without loss (VNNI). On older ones a sum
of two products saturates at 16 bits: 255 * 127 * 2 is more than 32767, 255 * 64 * 2 is less.
64-bit Arm has kernels for int8 by int8. WebAssembly widens to 16 bits before it multiplies."""
