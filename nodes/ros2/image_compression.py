"""Compresses images to JPEG and PNG, as sensor_msgs/CompressedImage messages like those of compressed_image_transport."""

from __future__ import annotations

import io
from typing import NamedTuple

from PIL import Image

from graphengine.messages import messages
from graphengine.node import BadValueError, Buffer
from graphengine.nodes.checked import one_of
from graphengine.nodes.ros2.publisher import bytes_in

COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
JPEG_QUALITY = 95
"""Default JPEG quality of compressed_image_transport."""
_PNG_LEVEL = 3
"""Default PNG compression level of compressed_image_transport; zlib's default of 6 gives smaller files in twice the time."""


class _Pixels(NamedTuple):
    """Properties of a pixel encoding.

    Args:
        mode: pillow's name of the pixel format.
        size: bytes per pixel.
        decoded: encoding of the decompressed pixels in the message's format string; empty if the pixels have no colours.
    """

    mode: str
    size: int
    decoded: str


_ENCODINGS = {
    "rgb8": _Pixels("RGB", 3, "bgr8"),
    "rgba8": _Pixels("RGBA", 4, "bgr8"),
    "mono8": _Pixels("L", 1, ""),
    "16UC1": _Pixels("I;16", 2, ""),
}
ENCODINGS = {"jpeg": ("rgb8", "rgba8", "mono8"), "png": tuple(_ENCODINGS)}
"""Pixel encodings that each compression accepts."""
_LONGEST = 65500
"""Maximum width and height that libjpeg compresses, pixels."""


def compressed(
    header: messages.Header,
    encoding: str,
    size: tuple[int, int],
    pixels: Buffer,
    compression: str,
    jpeg_quality: int = JPEG_QUALITY,
) -> messages.CompressedImage:
    """Return a message with the compressed image. With the same version of pillow, equal images give equal bytes.

    Args:
        header: time and frame.
        encoding: pixel format that `ENCODINGS` lists for the compression; an alpha channel is dropped.
        size: width and height, pixels.
        pixels: rows of pixels, top row first, little-endian.
        compression: `jpeg` or `png`; only `png` is lossless.
        jpeg_quality: 1 to 100.

    Raises:
        BadValueError: the compression does not accept the encoding, the image size is out of range, the size of the buffer does
            not match the image size and the encoding, or the quality is out of range.
    """
    legal_encodings = ENCODINGS[one_of("format", compression, ENCODINGS)]
    mode, pixel_bytes, decoded = _ENCODINGS[one_of("encoding", encoding, legal_encodings)]
    width, height = size
    if not (0 < width <= _LONGEST and 0 < height <= _LONGEST):
        raise BadValueError("width, height", [width, height], f"from 1 to {_LONGEST}")
    data, expected = bytes_in(pixels), width * height * pixel_bytes
    if len(data) != expected:
        legal = f"of {expected} bytes for {width} x {height} pixels of {encoding}"
        raise BadValueError("data, width, height, encoding, dataPtr", len(data), legal)
    picture = Image.frombuffer(mode, size, data, "raw", mode, 0, 1)
    if mode == "RGBA":
        picture = picture.convert("RGB")
    file = io.BytesIO()
    if compression == "png":
        picture.save(file, "PNG", compress_level=_PNG_LEVEL)
    elif 1 <= jpeg_quality <= 100:
        picture.save(file, "JPEG", quality=jpeg_quality)
    else:
        raise BadValueError("jpegQuality", jpeg_quality, "from 1 to 100")
    # Subscribers of image_transport read this string to learn the encoding to which they convert the decoded pixels.
    kind = f"{encoding}; {compression} compressed {decoded}"
    return messages.CompressedImage(header, kind, bytes_in(file.getbuffer()))
