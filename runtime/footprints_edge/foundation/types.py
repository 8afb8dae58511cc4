"""Array types that the stages exchange. Sizes and shapes are (height, width)."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Size: TypeAlias = tuple[int, int]
"""(height, width) in pixels."""

Rgb: TypeAlias = NDArray[np.uint8]
"""uint8 (H, W, 3), channels in the order red, green, blue."""

Floats: TypeAlias = NDArray[np.float32]
Mask: TypeAlias = NDArray[np.bool_]
