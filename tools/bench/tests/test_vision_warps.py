"""Synthetic pairs: the truth lays one picture on the other, and the same seed gives the same pixels."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from tools.bench.vision.warps import KINDS, SIZE, drawn_texture, warped_pairs


@pytest.mark.parametrize("kind", KINDS)
def test_the_truth_lays_one_picture_on_the_other(kind: str) -> None:
    for pair in warped_pairs([drawn_texture(1)], kind, 4, 3):
        assert pair.a.shape == pair.b.shape == SIZE[::-1]
        laid = cv2.warpPerspective(pair.a, pair.truth, SIZE, flags=cv2.INTER_AREA)
        both = cv2.warpPerspective(np.full(pair.a.shape, 255, np.uint8), pair.truth, SIZE) == 255
        smooth = [cv2.GaussianBlur(p.astype(np.float32), (0, 0), 3.0)[both] for p in (laid, pair.b)]
        assert np.corrcoef(*smooth)[0, 1] > 0.9, pair.name


def test_the_same_seed_gives_the_same_pixels() -> None:
    first, second = (next(warped_pairs([drawn_texture(1)], "warp", 1, 3)) for _ in range(2))
    np.testing.assert_array_equal(first.b, second.b)
