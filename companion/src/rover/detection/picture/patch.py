"""What the classifier is told about a spot of a picture that knows neither kelvin nor metres.

- features of a network trained on photographs, at three scales (`features`);
- the occupancy patch (paper section 4.1; `occupancy`);
- how large the spot is in its picture.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rover.detection.picture import features, occupancy
from rover.detection.picture.maps import PictureMaps

LENGTH = features.LENGTH + occupancy.LENGTH + 1

Block = NDArray[np.float32]


def describe_spots(maps: PictureMaps, spots: Block, seen: features.Features) -> Block:
    """Vectors (N, LENGTH) of spots (N, 3) x, y, diameter, pixels of the picture."""
    if not len(spots):
        return np.zeros((0, LENGTH), np.float32)
    size = np.log(spots[:, 2:3] / np.float32(max(maps.size)))
    return np.hstack((seen.describe(maps, spots), occupancy.occupancy(maps, spots), size)).astype(np.float32)
