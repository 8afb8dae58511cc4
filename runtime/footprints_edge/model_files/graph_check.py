"""What a model file may hold: checked before an engine sees a byte of it.

Engines take any graph, and some graphs end the process, never end, or fill the memory: there no
`try` helps. The networks of the contract need few operators, no sub-graphs and no other files, so
that is what is let through. What a graph of these operators computes is not looked at here.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

from footprints_edge.model_files.protobuf import (
    Value,
    fields,
    grouped,
    message_of,
    number_of,
    signed,
    varint_count,
    varints,
)

OPERATORS: dict[str, tuple[int, int]] = {
    "Abs": (1, 1),
    "Add": (2, 2),
    "AveragePool": (1, 1),
    "BatchNormalization": (5, 5),
    "Cast": (1, 1),
    "Clip": (1, 3),
    "Concat": (1, 64),
    "Constant": (0, 0),
    "Conv": (2, 3),
    "DepthToSpace": (1, 1),
    "DequantizeLinear": (2, 3),
    "Div": (2, 2),
    "Elu": (1, 1),
    "Exp": (1, 1),
    "Expand": (2, 2),
    "Gather": (2, 2),
    "GlobalAveragePool": (1, 1),
    "HardSigmoid": (1, 1),
    "HardSwish": (1, 1),
    "Identity": (1, 1),
    "LeakyRelu": (1, 1),
    "Max": (1, 8),
    "MaxPool": (1, 1),
    "Min": (1, 8),
    "Mul": (2, 2),
    "Neg": (1, 1),
    "Pad": (2, 4),
    "QuantizeLinear": (2, 3),
    "Reciprocal": (1, 1),
    "Relu": (1, 1),
    "Reshape": (2, 2),
    "Resize": (1, 4),
    "Shape": (1, 1),
    "Sigmoid": (1, 1),
    "Slice": (3, 5),
    "Split": (1, 2),
    "Sqrt": (1, 1),
    "Squeeze": (1, 2),
    "Sub": (2, 2),
    "Tanh": (1, 1),
    "Transpose": (1, 1),
    "Unsqueeze": (2, 2),
    "Where": (3, 3),
}
"""The operators of the contract, of ONNX's own domain, with the fewest and the most inputs."""

MAX_OPERATOR_SET = 100
"""Highest version of an operator set. OpenVINO counts down from it to one that it knows."""

MAX_NODES = 10_000
MAX_TEXT = 4096
"""Most bytes of a name or of a value of the metadata."""

_ITEM_BYTES = {1: 4, 2: 1, 3: 1, 6: 4, 7: 8, 9: 1, 10: 2, 11: 8}
"""Bytes of an element by ONNX's number of its type: float, bytes, integers, bool, half, double."""

_INT64 = 7
_LISTED = {1, _INT64}
_MAX_LISTED = 16
"""Tensors of so few floats or integers may be scales or shapes: their numbers are looked at."""

_MAX_RANK = 8
_MAX_ELEMENTS = 2**24
"""Most elements of a shape that a file states: as many as 64 full maps of the usual input."""

_NO_END = 2**31 - 1
"""Integers from here on mean "to the end" of a slice."""

_WINDOWS = {"kernel_shape": 1, "strides": 1, "dilations": 1, "pads": 0, "group": 1, "blocksize": 1}
"""Attributes of convolutions and their like, with their least value."""

_MAX_WINDOW = {"group": 2**16}
_MAX_NUMBER = 2**16
_MAX_SIDE = 256
_MAX_SCALE = 64.0


Constant: TypeAlias = tuple[float, ...]
"""The numbers of a tensor that has few; of others, none."""


@dataclass(frozen=True)
class _Node:
    operator: str
    inputs: list[str]
    outputs: list[str]
    constant: Constant | None


def check_graph(data: bytes) -> None:
    """Checks the bytes of an ONNX file.

    Raises:
        ValueError: If it is damaged or holds what no file of the contract needs; the message says
            what.
    """
    model = grouped(memoryview(data))
    _refuse(model, {20: "training steps", 25: "functions"})
    for value in _all(model, 2, 3, 4, 6):
        _text(value)
    for entry in model.get(14, ()):  # metadata
        for _, part in fields(message_of(entry)):
            if not isinstance(part, int):
                _text(part)
    for entry in model.get(8, ()):
        _check_operator_set(message_of(entry))
    if len(model.get(7, ())) != 1:
        raise ValueError(f"it has {len(model.get(7, ()))} graphs")
    graph = grouped(message_of(model[7][0]))
    _refuse(graph, {15: "sparse tensors"})
    nodes = [_read_node(message_of(node)) for node in graph.get(1, ())]
    if len(nodes) > MAX_NODES:
        raise ValueError(f"it has more than {MAX_NODES} nodes")
    constants = dict(_read_tensor(message_of(tensor)) for tensor in graph.get(5, ()))
    constants |= {node.outputs[0]: node.constant for node in nodes if node.constant is not None}
    given = [_check_value(message_of(value)) for value in graph.get(11, ())]
    for value in _all(graph, 12, 13):
        _check_value(message_of(value))
    _check_order(nodes, {"", *given, *constants})
    for node in nodes:
        _check_sizes(node, constants)


def _check_operator_set(data: memoryview) -> None:
    entry = grouped(data)
    for domain in entry.get(1, ()):
        _text(domain)
    for version in map(number_of, entry.get(2, ())):
        if not 1 <= version <= MAX_OPERATOR_SET:
            raise ValueError(f"its operators are of version {version}")


def _all(message: dict[int, list[Value]], *numbers: int) -> Iterator[Value]:
    return chain.from_iterable(message.get(number, ()) for number in numbers)


def _refuse(message: dict[int, list[Value]], kinds: dict[int, str]) -> None:
    for number, kind in kinds.items():
        if number in message:
            raise ValueError(f"it has {kind}, which no file of footprints-edge has")


def _text(value: Value) -> str:
    data = message_of(value)
    if len(data) > MAX_TEXT:
        raise ValueError(f"a text in it has {len(data)} bytes")
    try:
        return str(data, "utf-8")
    except UnicodeDecodeError:
        raise ValueError("a text in it is not UTF-8") from None


def _last_text(message: dict[int, list[Value]], number: int) -> str:
    return _text(message[number][-1]) if number in message else ""


def _shown(name: str) -> str:
    return repr(name[:60])


def _read_node(data: memoryview) -> _Node:
    node = grouped(data)
    inputs, outputs = ([_text(value) for value in node.get(number, ())] for number in (1, 2))
    operator, domain = _last_text(node, 4), _last_text(node, 7)
    if domain not in {"", "ai.onnx"} or operator not in OPERATORS or _last_text(node, 8):
        full = f"{domain}.{operator}" if domain else operator
        raise ValueError(f"the file contract does not have its operator {_shown(full)}")
    least, most = OPERATORS[operator]
    if not least <= len(inputs) <= most or "" in inputs[:least]:
        raise ValueError(f"its operator {operator} has {len(inputs)} inputs")
    if not 1 <= len(outputs) <= (64 if operator == "Split" else 1) or "" in outputs:
        raise ValueError(f"its operator {operator} has {len(outputs)} outputs")
    tensors = [_read_attribute(message_of(value)) for value in node.get(5, ())]
    constant = next((tensor for tensor in tensors if tensor is not None), None)
    if operator == "Constant" and constant is None:
        raise ValueError("a constant in it has no tensor")
    return _Node(operator, inputs, outputs, constant if operator == "Constant" else None)


def _read_attribute(data: memoryview) -> Constant | None:
    """Checks an attribute; the tensor in it, if any."""
    attribute = grouped(data)
    name = _last_text(attribute, 1)
    _refuse(
        attribute,
        {6: "sub-graphs", 10: "lists of tensors", 11: "sub-graphs", 14: "types", 15: "types"}
        | {21: "functions", 22: "sparse tensors", 23: "sparse tensors"},
    )
    for text in _all(attribute, 4, 9, 13):
        _text(text)
    if not all(map(math.isfinite, _floats(_all(attribute, 2, 7)))):
        raise ValueError(f"its attribute {_shown(name)} is not finite")
    if name in _WINDOWS:
        least, most = _WINDOWS[name], _MAX_WINDOW.get(name, _MAX_SIDE)
    else:
        least, most = -_MAX_NUMBER, _MAX_NUMBER
    for entry in _integers(_all(attribute, 3, 8)):
        if not least <= entry <= most:
            raise ValueError(f"its attribute {_shown(name)} is {entry}")
    tensors = [_read_tensor(message_of(value))[1] for value in attribute.get(5, ())]
    return tensors[-1] if tensors else None


def _integers(values: Iterable[Value]) -> Iterator[int]:
    for value in values:
        yield from map(signed, (value,) if isinstance(value, int) else varints(value))


def _floats(values: Iterable[Value]) -> Iterator[float]:
    for value in values:
        data = message_of(value)
        if len(data) % 4:
            raise ValueError("floats in it are cut off")
        yield from data.cast("f") if len(data) else ()


def _read_tensor(data: memoryview) -> tuple[str, Constant]:
    """The name of a tensor, and its numbers if they are few; its dims must agree with its bytes."""
    tensor = grouped(data)
    name = _last_text(tensor, 8)
    if 13 in tensor or any(value != 0 for value in tensor.get(14, ())):
        raise ValueError("its weights are in another file; footprints-edge takes one file")
    _refuse(tensor, {3: "parts of tensors", 6: "texts", 10: "doubles", 11: "uint64 numbers"})
    kind = number_of(tensor[2][-1]) if 2 in tensor else 0
    dims = list(_integers(tensor.get(1, ())))
    if kind not in _ITEM_BYTES:
        raise ValueError(f"its tensor {_shown(name)} is of type {kind}")
    if len(dims) > _MAX_RANK or min(dims, default=0) < 0:
        raise ValueError(f"its tensor {_shown(name)} has the shape {dims[:12]}")
    expected, raw = math.prod(dims), memoryview(b"")
    for value in tensor.get(9, ()):  # of several, the last one counts
        raw = message_of(value)
    elements = len(raw) / _ITEM_BYTES[kind]
    elements += sum(len(message_of(value)) for value in tensor.get(4, ())) / 4
    for value in _all(tensor, 5, 7):
        elements += 1 if isinstance(value, int) else varint_count(value)
    if elements != expected:
        raise ValueError(
            f"its tensor {_shown(name)} has the shape {dims}, but {elements:g} elements"
        )
    if expected > _MAX_LISTED:
        return name, ()
    numbers: list[float] = [*_floats(tensor.get(4, ())), *_integers(_all(tensor, 5, 7))]
    if kind in _LISTED and len(raw):
        numbers += raw.cast("f") if kind == 1 else raw.cast("q")
    if kind == _INT64:
        _check_shape(name, numbers)
    return name, tuple(numbers)


def _check_shape(name: str, numbers: list[float]) -> None:
    """Few integers may be a shape that something is expanded to."""
    sides = [abs(number) for number in numbers if 1 < abs(number) < _NO_END]
    if math.prod(sides) > _MAX_ELEMENTS:
        raise ValueError(f"its constant {_shown(name)} is {numbers}: too large for a shape")


def _check_sizes(node: _Node, constants: dict[str, Constant]) -> None:
    """What makes maps larger is a small constant."""
    at = {"Pad": 1, "Resize": 2, "Expand": 1}.get(node.operator)
    if at is None or at >= len(node.inputs):
        return
    numbers = constants.get(node.inputs[at], ())
    most = {"Pad": _MAX_SIDE, "Resize": _MAX_SCALE, "Expand": _MAX_ELEMENTS}[node.operator]
    if not all(abs(number) <= most for number in numbers):  # NaN is not
        raise ValueError(f"its operator {node.operator} has the sizes {list(numbers)}")


def _check_order(nodes: list[_Node], known: set[str]) -> None:
    """Every value is there before it is used, so nothing goes in a circle."""
    for node in nodes:
        for name in node.inputs:
            if name not in known:
                raise ValueError(f"its operator {node.operator} needs {_shown(name)} too early")
        if node.constant is None and not known.isdisjoint(node.outputs):
            raise ValueError(f"it makes {_shown(node.outputs[0])} twice")
        known.update(node.outputs)


def _check_value(data: memoryview) -> str:
    """The type of an input, of an output or of a value between is a tensor's; its name."""
    value = grouped(data)
    for kind in value.get(2, ()):
        if not grouped(message_of(kind)).keys() <= {1, 6}:
            raise ValueError("it has values that are not tensors")
    return _last_text(value, 1)
