"""The contract of a model file: checks that need no image, and its metadata."""

from pathlib import Path

import onnx
import onnx_ir as ir
from onnx import TensorProto

from footprints_edge.model_files.metadata import ModelMetadata
from footprints_edge_export.errors import VerificationError


def check_file(path: Path) -> None:
    """Check a file against the contract.

    Raises:
        VerificationError: the file is not valid ONNX, needs other files or non-standard operators,
            or has another input or output than the contract says.
        ModelError: the metadata break the contract.
    """
    try:
        onnx.checker.check_model(path, full_check=True)
    except (onnx.checker.ValidationError, onnx.shape_inference.InferenceError) as error:
        raise VerificationError(f"{path.name}: not valid ONNX: {error}") from error
    model = onnx.load(path, load_external_data=False)
    if any(t.data_location == TensorProto.EXTERNAL for t in model.graph.initializer):
        raise VerificationError(f"{path.name}: weights lie outside the file")
    foreign = sorted(
        {f"{node.domain}.{node.op_type}" for node in model.graph.node if node.domain}
        | {opset.domain for opset in model.opset_import if opset.domain}
    )
    if foreign or model.functions:
        raise VerificationError(f"{path.name}: operators outside standard ONNX: {foreign}")
    found = {
        value.name: (value.type.tensor_type.elem_type, len(value.type.tensor_type.shape.dim))
        for value in (*model.graph.input, *model.graph.output)
    }
    expected = {"image": (TensorProto.UINT8, 4), "maps": (TensorProto.FLOAT, 4)}
    if found != expected:
        raise VerificationError(f"{path.name}: input and output are {found}, not {expected}")
    ModelMetadata.from_props({p.key: p.value for p in model.metadata_props}, path.name)


def set_metadata(model: ir.Model, metadata: ModelMetadata) -> None:
    """Replace a model's metadata by the contract's, in place."""
    model.metadata_props.clear()
    model.metadata_props.update(metadata.to_props())
    model.producer_name, model.producer_version = "footprints-edge", None
