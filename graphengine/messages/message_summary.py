"""Summarizes messages with many values (laser scans, images and point clouds) in a few lines of text.

Messages come from the network, so sizes and lengths in a message may contradict each other.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

BARS, SHADES = "▁▂▃▄▅▆▇█", " ░▒▓█"
PICTURE_WIDTH = 64
"""Maximum width of an image drawn with block characters, in characters."""
_KINDS = {"S": "i", "U": "u", "F": "f"}
_POINT_TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""NumPy's type codes for the values of `datatype` in sensor_msgs/PointField."""

_UNREADABLE = "values not shown: an unknown encoding, or data of another size"

Values = NDArray[Any]


def summarize(message: Any, width: int, *, picture: bool = True) -> str | None:
    """Return a summary of a message in a few lines; None if its type has no summary.

    Args:
        message: decoded message.
        width: maximum number of characters in a line of a sparkline or a drawn image.
        picture: whether to draw an image message with block characters.
    """
    summary = _SUMMARIES.get(message.__msgtype__)
    if summary is None:
        return None
    stamp, kind = message.header.stamp, message.__msgtype__.rpartition("/")[2]
    head = f"{kind} of frame {message.header.frame_id!r} at {stamp.sec + stamp.nanosec * 1e-9:.3f} s"
    return "\n  ".join([head, *summary(message, width - 2, picture)])


def _scan(scan: Any, width: int, picture: bool) -> list[str]:
    first, last = math.degrees(scan.angle_min), math.degrees(scan.angle_max)
    ranges = np.asarray(scan.ranges, np.float64)
    hits = np.isfinite(ranges) & (ranges >= scan.range_min) & (ranges <= scan.range_max)
    rate = f", {1.0 / scan.scan_time:.4g} Hz" if scan.scan_time > 0.0 else ""
    limits = f"can measure {scan.range_min:.4g} to {scan.range_max:.4g} m"
    returns = f"ranges {_extent(ranges[hits])} m, {len(ranges) - int(hits.sum())} without return"
    lines = [
        f"{len(ranges)} beams from {first:.1f} to {last:.1f} deg{rate}, {limits}",
        returns if hits.any() else "no return",
    ]
    if len(scan.intensities):
        lines.append(f"intensities {_extent(scan.intensities)}")
    ends = f"{first:.1f} deg ", f" {last:.1f} deg"
    line = sparkline(np.where(hits, ranges, np.nan), width - sum(map(len, ends)))
    return [*lines, line.join(ends)] if line.strip() else lines


def sparkline(values: Values, width: int) -> str:
    """Return a line of bars that shows the values.

    Each bar shows the smallest finite value in one of several equal parts of the values. The tallest bar shows the largest of
    these smallest values. A part without finite values gives a space.
    """
    count = min(width, len(values))
    if count < 1:
        return ""
    shares = [share[np.isfinite(share)] for share in np.array_split(values, count)]
    least = [float(share.min()) if share.size else math.nan for share in shares]
    top = max((value for value in least if value > 0.0), default=1.0)
    return "".join(" " if math.isnan(x) else BARS[min(max(int(x / top * 8.0), 0), 7)] for x in least)


def _image(image: Any, width: int, picture: bool) -> list[str]:
    size = f"{image.width} x {image.height}, {image.encoding}, {len(image.data)} bytes"
    pixels = _pixels(image)
    if pixels is None:
        return [size, _UNREADABLE]
    names = _channels(image.encoding) or [f"channel {index}" for index in range(pixels.shape[2])]
    names = [""] if pixels.shape[2] == 1 else [f"{name} " for name in names]
    lines = [size, "; ".join(f"{name}{_extent(pixels[..., i], mean=True)}" for i, name in enumerate(names))]
    return [*lines, *_shaded(pixels[..., :3].mean(axis=2), width)] if picture else lines


def _channels(encoding: str) -> list[str]:
    """Return the names of the channels of a colour encoding such as `rgb8`, in order; empty for other encodings."""
    match = re.fullmatch(r"(rgb|bgr)(a?)(8|16)", encoding)
    colours = {"r": "red", "g": "green", "b": "blue", "a": "alpha"}
    return [colours[letter] for letter in match[1] + match[2]] if match else []


def _pixels(image: Any) -> Values | None:
    """Return an Image message as an array of shape (height, width, channels).

    Return None if the encoding is unknown, or the size of the data does not match the encoding and the image size.
    """
    match = re.fullmatch(r"(8|16|32|64)([USF])C([1-4]?)", image.encoding)
    if match and (match[1], match[2]) != ("8", "F"):
        kind, channels = f"{_KINDS[match[2]]}{int(match[1]) // 8}", int(match[3] or 1)
    elif names := _channels(image.encoding) or re.fullmatch(r"mono(8|16)", image.encoding):
        kind, channels = f"u{2 if image.encoding.endswith('16') else 1}", len(names) if isinstance(names, list) else 1
    else:
        return None
    dtype = np.dtype(kind).newbyteorder(">" if image.is_bigendian else "<")
    row = image.width * channels * dtype.itemsize
    data = np.asarray(image.data, np.uint8)
    if not row or not image.height or image.step < row or len(data) != image.step * image.height:
        return None
    rows = np.ascontiguousarray(data.reshape(image.height, image.step)[:, :row])
    return rows.view(dtype).reshape(image.height, image.width, channels)


def _shaded(brightness: Values, width: int) -> list[str]:
    """Return the lines of an image drawn with block characters, each twice as high as wide.

    Args:
        brightness: brightness of each pixel, shape (height, width); the range of values is scaled to the shades.
        width: maximum number of characters in a line.
    """
    height, wide = brightness.shape
    columns = min(width, PICTURE_WIDTH, wide)
    rows = max(round(columns * height / wide / 2.0), 1)
    if columns < 1 or rows > 4 * PICTURE_WIDTH:
        return []
    picked = brightness[np.ix_(_middles(height, rows), _middles(wide, columns))]
    finite = picked[np.isfinite(picked)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    scaled = np.nan_to_num((picked - low) / ((high - low) or 1.0), nan=0.0, posinf=1.0, neginf=0.0)
    return ["".join(SHADES[level] for level in row) for row in np.minimum((scaled * 5.0).astype(int), 4)]


def _middles(count: int, parts: int) -> NDArray[np.intp]:
    """Divide the indices from 0 to `count` - 1 into equal parts, and return the middle index of each part."""
    return ((np.arange(parts) + 0.5) * count / parts).astype(np.intp)


def _cloud(cloud: Any, width: int, picture: bool) -> list[str]:
    count = cloud.width * cloud.height
    fields = [field for field in cloud.fields if field.count == 1 and field.datatype in _POINT_TYPES]
    size = f"{count} points ({cloud.width} x {cloud.height}) of {cloud.point_step} bytes"
    lines = [f"{size}: {', '.join(field.name for field in cloud.fields) or 'no fields'}"]
    points = _points(cloud, fields)
    if points is None:
        return [*lines, _UNREADABLE]
    finite = np.ones(count, bool)
    for index in range(len(fields)):
        finite &= np.isfinite(points[f"f{index}"])
    bounds = [f"{field.name} {_extent(points[f'f{index}'][finite])}" for index, field in enumerate(fields)]
    missing = count - int(finite.sum())
    return [*lines, ", ".join(bounds), *([f"without finite values: {missing}"] if missing else [])]


def _points(cloud: Any, fields: list[Any]) -> Values | None:
    """Return the points of a cloud as a structured array with a field f0, f1, … for each of `fields`.

    Return None if there are no fields, or the size of the data does not match the cloud's layout.
    """
    order = ">" if cloud.is_bigendian else "<"
    kinds = [order + _POINT_TYPES[field.datatype] for field in fields]
    ends = [field.offset + np.dtype(kind).itemsize for field, kind in zip(fields, kinds, strict=True)]
    row, step, data = cloud.row_step, cloud.point_step, np.asarray(cloud.data, np.uint8)
    if not fields or max(ends) > step or row < cloud.width * step or len(data) != row * cloud.height or not len(data):
        return None
    names = [f"f{index}" for index in range(len(fields))]
    offsets = [field.offset for field in fields]
    dtype = np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": step})
    rows = np.ascontiguousarray(data.reshape(cloud.height, row)[:, : cloud.width * step])
    return rows.reshape(-1).view(dtype)


def _extent(values: Values, *, mean: bool = False) -> str:
    """Return the range of the finite values as text, such as `0.5 to 12`.

    With `mean`, the text also has the mean and the number of values that are not finite.
    """
    array = np.asarray(values, np.float64)
    finite = array[np.isfinite(array)]
    if not finite.size:
        return "none"
    odd = f", {array.size - finite.size} not finite" if mean and finite.size < array.size else ""
    middle = f", mean {finite.mean():.4g}" if mean else ""
    return f"{finite.min():.4g} to {finite.max():.4g}{middle}{odd}"


_SUMMARIES: dict[str, Callable[[Any, int, bool], list[str]]] = {
    "sensor_msgs/msg/LaserScan": _scan,
    "sensor_msgs/msg/Image": _image,
    "sensor_msgs/msg/PointCloud2": _cloud,
}
