"""The file is read back by a reader that is not ours."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from thermoroll_cli.plots.png import png_of


@pytest.mark.parametrize("channels", [3, 4])
def test_every_pixel_and_the_resolution_are_kept(channels: int) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (31, 47, channels), dtype=np.uint8)
    with Image.open(io.BytesIO(png_of(pixels, 200.0))) as image:
        image.verify()
    with Image.open(io.BytesIO(png_of(pixels, 200.0))) as image:
        assert image.mode == "RGB" and image.info["dpi"] == pytest.approx((200.0, 200.0), abs=0.1)
        np.testing.assert_array_equal(np.asarray(image), pixels[:, :, :3])
