"""Pictures of the head camera as ROS 2 messages, under the names that realsense-ros uses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mobius.bridge.to_ros import STORE, header
from mobius.errors import InvalidInput

__all__ = ["Picture", "focal", "image", "info", "pixels"]

_FRAME = "camera_color_optical_frame"


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture of a camera without distortion."""

    stamp: float
    """When it was taken [s]."""
    pixels: NDArray[np.uint8]
    """(height, width, 3) red, green, blue, row 0 on top."""
    focal: float
    """Focal length [px]."""

    def __post_init__(self) -> None:
        if self.pixels.ndim != 3 or self.pixels.shape[2] != 3 or self.pixels.dtype != np.uint8:
            raise InvalidInput(
                f"Picture.pixels: expected (height, width, 3) bytes, got {self.pixels.shape}"
                f" {self.pixels.dtype}"
            )


def image(picture: Picture) -> Any:
    """The pixels as rgb8."""
    height, width, _ = picture.pixels.shape
    return STORE.types["sensor_msgs/msg/Image"](
        header=header(picture.stamp, _FRAME),
        height=height,
        width=width,
        encoding="rgb8",
        is_bigendian=0,
        step=3 * width,
        data=np.ascontiguousarray(picture.pixels).reshape(-1),
    )


def info(picture: Picture) -> Any:
    """How the camera projects: pinhole, principal point in the middle.

    ROS and OpenCV count pixels from the centre of the first one, which is 0: the middle of four
    pixels is 1.5.
    """
    height, width, _ = picture.pixels.shape
    f, cx, cy = picture.focal, 0.5 * (width - 1), 0.5 * (height - 1)
    types = STORE.types
    return types["sensor_msgs/msg/CameraInfo"](
        header=header(picture.stamp, _FRAME),
        height=height,
        width=width,
        distortion_model="plumb_bob",
        d=np.zeros(5),
        k=np.array([f, 0, cx, 0, f, cy, 0, 0, 1], dtype=float),
        r=np.eye(3).ravel(),
        p=np.array([f, 0, cx, 0, 0, f, cy, 0, 0, 0, 1, 0], dtype=float),
        binning_x=0,
        binning_y=0,
        roi=types["sensor_msgs/msg/RegionOfInterest"](
            x_offset=0, y_offset=0, height=0, width=0, do_rectify=False
        ),
    )


def pixels(message: Any) -> NDArray[np.uint8]:
    """(height, width, 3) of an rgb8 Image."""
    return np.asarray(message.data, dtype=np.uint8).reshape(message.height, message.width, 3)


def focal(message: Any) -> float:
    """Focal length [px]."""
    return float(message.k[0])
