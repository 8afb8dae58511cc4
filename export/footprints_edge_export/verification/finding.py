"""One comparison of a port with the test vectors, and overlap of masks."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Finding:
    """One comparison.

    Attributes:
        vector: name of the vector.
        quantity: what was compared.
        measured: the difference, in words; or why there is none.
        allowed: the largest difference allowed, in words.
        holds: whether the difference is allowed.
        checked: whether there was anything to compare; False for what is optional and not written.
    """

    vector: str
    quantity: str
    measured: str
    allowed: str
    holds: bool
    checked: bool = True

    def __str__(self) -> str:
        """One line of a report."""
        if not self.checked:
            return f"not checked {self.vector}: {self.quantity}: {self.measured} ({self.allowed})"
        verdict = "ok     " if self.holds else "DIFFERS"
        return f"{verdict} {self.vector}: {self.quantity}: {self.measured} ({self.allowed})"


def iou(a: NDArray[np.bool_], b: NDArray[np.bool_]) -> float:
    """Intersection over union of two masks; 1 where both are empty."""
    union = int((a | b).sum())
    return float((a & b).sum() / union) if union else 1.0
