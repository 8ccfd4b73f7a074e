"""A second reader of Nav2's maps, pixel by pixel with plain Python: what the tests compare with."""

import io

import yaml
from PIL import Image


def reference(text: str, picture: bytes) -> list[list[int]]:
    """Values as nav_msgs/OccupancyGrid has them, row 0 the lowest (Nav2's map_io, its loops written out)."""
    told = yaml.safe_load(text)
    mode, free, occupied = told.get("mode", "trinary"), told["free_thresh"], told["occupied_thresh"]
    image = Image.open(io.BytesIO(picture))
    rows = []
    for y in range(image.height - 1, -1, -1):
        row = []
        for x in range(image.width):
            pixel = image.getpixel((x, y))
            bands = dict(zip(image.getbands(), pixel if isinstance(pixel, tuple) else (pixel,), strict=True))
            alpha = bands.pop("A", None)
            shades = list(bands.values()) if len(bands) == 3 else list(bands.values()) * 3
            if mode == "trinary" and alpha is not None:
                shades.append(alpha)
            shade = sum(shades) / len(shades) / 255
            p = shade if told.get("negate") else 1 - shade
            if mode == "raw":
                level = round(shade * 255)
                row.append(level if level <= 100 else -1)
            elif mode == "scale" and alpha is not None and alpha != 255:
                row.append(-1)
            elif p >= occupied:
                row.append(100)
            elif p <= free:
                row.append(0)
            else:
                row.append(-1 if mode == "trinary" else round((p - free) / (occupied - free) * 100))
        rows.append(row)
    return rows
