"""What a model file is made for: kinds of processors and of runtimes, and what each wants."""

from dataclasses import dataclass

from onnxruntime.quantization import QuantType


@dataclass(frozen=True)
class Target:
    """What a kind of processor or runtime wants.

    Attributes:
        activations: uint8 or int8, where the file is int8.
        reduce_range: 7-bit weights, where the CPU's multiply-add would saturate with 8.
        size: (H, W) that the input is fixed to where the caller names none; None leaves it free.
        plain_padding: whether reflecting Pads are written as Slice and Concat.
        ort_format: whether the file is also written in onnxruntime's own format, ``.ort``.
    """

    activations: QuantType
    reduce_range: bool = False
    size: tuple[int, int] | None = None
    plain_padding: bool = False
    ort_format: bool = False


TARGETS = {
    "x86-vnni": Target(QuantType.QUInt8),
    "x86-avx2": Target(QuantType.QUInt8, reduce_range=True),
    "arm64": Target(QuantType.QInt8),
    "web": Target(QuantType.QUInt8, plain_padding=True),
    "mobile": Target(QuantType.QInt8, size=(256, 448), plain_padding=True, ort_format=True),
}
"""x86 since 2019 or so multiplies uint8 with int8 without loss (VNNI); before that pairs of
products saturate at 16 bits, 255 * 127 * 2 being more than 32767, and 255 * 64 * 2 less; 64-bit
Arm has kernels for int8 with int8. WebAssembly widens to 16 bits before it multiplies."""
