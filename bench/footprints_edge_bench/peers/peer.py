"""What a peer is: a method of the paper's speed table, as far as its time depends on it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from numpy.typing import NDArray

if TYPE_CHECKING:
    from torch import nn

Arrays: TypeAlias = tuple[NDArray[Any], ...]
Run: TypeAlias = Callable[..., Arrays]
"""A network in an engine: arrays in, arrays out."""


@dataclass(frozen=True)
class PeerNetwork:
    """A network with random weights, and arrays of the shapes that it takes.

    Attributes:
        module: in evaluation mode; takes one tensor for each example and returns a tuple.
        examples: arrays in the order of its arguments.
    """

    module: "nn.Module"
    examples: Arrays


@dataclass(frozen=True)
class Peer:
    """A method of the paper's speed table.

    Attributes:
        method: its row, as ``paper_table.PAPER`` names it.
        networks: makes its networks, by name.
        prepare: makes the input of `infer` from a raw frame: the table's preprocessing.
        infer: one frame, from the prepared input and the running networks.
        leaves_out: what the method does beyond this.
    """

    method: str
    networks: Callable[[], Mapping[str, PeerNetwork]]
    prepare: Callable[[], Any]
    infer: Callable[[Mapping[str, Run], Any], object]
    leaves_out: str
