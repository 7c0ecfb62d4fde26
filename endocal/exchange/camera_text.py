"""A camera as text: OpenCV's YAML and JSON, ROS's camera_info YAML, Gyroflow's lens profile."""

from __future__ import annotations

import json
from typing import Any

from .._version import __version__
from .fit_camera import CameraFit


def opencv_yaml(fit: CameraFit) -> str:
    """Return the file that ``cv2.FileStorage`` reads: OpenCV's own names for calibrations."""
    camera = fit.camera
    lines = [
        "%YAML:1.0",
        "---",
        f"# {_origin(fit)}",
        f"image_width: {camera.size[0]}",
        f"image_height: {camera.size[1]}",
        *_opencv_matrix("camera_matrix", camera.matrix.tolist()),
        *_opencv_matrix("distortion_coefficients", [list(camera.coefficients)]),
    ]
    if camera.circle is not None:
        lines.append(f"visible_circle: {list(camera.circle)}")
    return "\n".join(lines) + "\n"


def opencv_json(fit: CameraFit) -> str:
    """Return the same as JSON, for ``cv2.FileStorage`` and any JSON reader."""
    camera = fit.camera
    document: dict[str, Any] = {
        "comment": _origin(fit),
        "image_width": camera.size[0],
        "image_height": camera.size[1],
        "camera_matrix": _json_matrix(camera.matrix.tolist()),
        "distortion_coefficients": _json_matrix([list(camera.coefficients)]),
    }
    if camera.circle is not None:
        document["visible_circle"] = list(camera.circle)
    return json.dumps(document, indent=4) + "\n"


def ros_camera_info(fit: CameraFit, name: str) -> str:
    """Return the YAML of ROS's camera_calibration_parsers; ``name`` is the camera's.

    Rectified pictures keep the camera matrix, so that they are those of ``endocal correct``.
    """
    camera = fit.camera
    model = "plumb_bob" if len(camera.coefficients) == 5 else "rational_polynomial"
    k = camera.matrix.tolist()
    return "\n".join(
        [
            f"# {_origin(fit)}",
            f"image_width: {camera.size[0]}",
            f"image_height: {camera.size[1]}",
            f"camera_name: {json.dumps(name)}",
            *_ros_matrix("camera_matrix", k),
            f"distortion_model: {model}",
            *_ros_matrix("distortion_coefficients", [list(camera.coefficients)]),
            *_ros_matrix(
                "rectification_matrix", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            ),
            *_ros_matrix("projection_matrix", [[*row, 0.0] for row in k]),
            "",
        ]
    )


def gyroflow_profile(fit: CameraFit, name: str) -> str:
    """Return a Gyroflow lens profile of its model ``opencv_standard``, for a camera called ``name``.

    ``asymmetrical`` makes Gyroflow take the principal point from the matrix rather than the frame's middle.
    """
    camera = fit.camera
    size = {"w": camera.size[0], "h": camera.size[1]}
    profile = {
        "name": name,
        "note": _origin(fit),
        "calibrated_by": "",
        "camera_brand": "",
        "camera_model": name,
        "lens_model": "",
        "camera_setting": "",
        "calib_dimension": size,
        "orig_dimension": size,
        "input_horizontal_stretch": 1.0,
        "input_vertical_stretch": 1.0,
        "num_images": 1,
        "asymmetrical": True,
        "distortion_model": "opencv_standard",
        "fisheye_params": {
            "RMS_error": float(f"{fit.rms:.3g}"),
            "camera_matrix": camera.matrix.tolist(),
            "distortion_coeffs": list(camera.coefficients),
        },
        # Gyroflow refuses a profile that names no calibrator.
        "calibrator_version": f"endocal {__version__}",
    }
    return json.dumps(profile, indent=2, ensure_ascii=False) + "\n"


def _origin(fit: CameraFit) -> str:
    return (
        f"From a division model by endocal {__version__}: at most {fit.largest:.2g} px off over the content."
        " The focal length only scales the coefficients."
    )


def _numbers(rows: list[list[float]]) -> str:
    return "[" + ", ".join(repr(float(v)) for row in rows for v in row) + "]"


def _opencv_matrix(key: str, rows: list[list[float]]) -> list[str]:
    return [
        f"{key}: !!opencv-matrix",
        f"   rows: {len(rows)}",
        f"   cols: {len(rows[0])}",
        "   dt: d",
        f"   data: {_numbers(rows)}",
    ]


def _json_matrix(rows: list[list[float]]) -> dict[str, Any]:
    data = [v for row in rows for v in row]
    return {
        "type_id": "opencv-matrix",
        "rows": len(rows),
        "cols": len(rows[0]),
        "dt": "d",
        "data": data,
    }


def _ros_matrix(key: str, rows: list[list[float]]) -> list[str]:
    return [
        f"{key}:",
        f"  rows: {len(rows)}",
        f"  cols: {len(rows[0])}",
        f"  data: {_numbers(rows)}",
    ]
