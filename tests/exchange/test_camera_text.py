"""The files say what their tools read, and are read back; foreign and broken ones are told apart."""

from __future__ import annotations

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from endocal.errors import InputError
from endocal.exchange import camera_text
from endocal.exchange.camera import Camera
from endocal.exchange.fit_camera import fit_camera
from endocal.exchange.read_camera import read_camera
from tests.exchange import lenses


def fitted(rational: bool = False):
    model, radius = lenses.anamorphic()
    fit = fit_camera(model, radius, rational)
    return replace(fit, camera=replace(fit.camera, circle=(360.0, 288.0, 560.0)))


@pytest.mark.parametrize("write", [camera_text.opencv_yaml, camera_text.opencv_json])
@pytest.mark.parametrize("rational", [False, True])
def test_opencv_reads_its_file(write, rational: bool) -> None:
    fit = fitted(rational)
    text = write(fit)
    storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    assert np.array_equal(storage.getNode("camera_matrix").mat(), fit.camera.matrix)
    coefficients = storage.getNode("distortion_coefficients").mat()
    assert np.array_equal(coefficients, [fit.camera.coefficients])
    assert storage.getNode("image_width").real() == 720
    assert read_camera(text) == fit.camera


@pytest.mark.parametrize(
    ("rational", "model"), [(False, "plumb_bob"), (True, "rational_polynomial")]
)
def test_ros_camera_info(rational: bool, model: str) -> None:
    yaml = pytest.importorskip(
        "yaml", reason="PyYAML, what ROS reads camera_info with, is not there"
    )
    fit = fitted(rational)
    text = camera_text.ros_camera_info(fit, "scope: 1 #2")
    info = yaml.safe_load(text)
    assert (info["image_width"], info["image_height"]) == fit.camera.size
    assert info["camera_name"] == "scope: 1 #2"
    assert info["distortion_model"] == model
    for key, shape in (
        ("camera_matrix", (3, 3)),
        ("distortion_coefficients", (1, len(fit.camera.coefficients))),
        ("rectification_matrix", (3, 3)),
        ("projection_matrix", (3, 4)),
    ):
        assert (info[key]["rows"], info[key]["cols"]) == shape
        assert len(info[key]["data"]) == shape[0] * shape[1]
    k = np.reshape(info["camera_matrix"]["data"], (3, 3))
    assert np.array_equal(k, fit.camera.matrix)
    assert np.array_equal(np.reshape(info["projection_matrix"]["data"], (3, 4))[:, :3], k)
    assert read_camera(text) == replace(fit.camera, circle=None)


def test_gyroflow_profile_holds_what_gyroflow_asks_for() -> None:
    fit = fitted(rational=True)
    profile = json.loads(camera_text.gyroflow_profile(fit, "scope"))
    assert profile["calibrator_version"]
    assert profile["distortion_model"] == "opencv_standard"
    assert profile["asymmetrical"] is True
    assert profile["calib_dimension"] == profile["orig_dimension"] == {"w": 720, "h": 576}
    parameters = profile["fisheye_params"]
    assert np.array_equal(parameters["camera_matrix"], fit.camera.matrix)
    # Its order is OpenCV's: k1 k2 p1 p2 k3 k4 k5 k6.
    assert tuple(parameters["distortion_coeffs"]) == fit.camera.coefficients


def test_plain_json_of_lists() -> None:
    text = json.dumps(
        {"K": [[500, 0, 320], [0, 501, 240], [0, 0, 1]], "dist": [[-0.1, 0.02, 0, 0]]}
    )
    camera = read_camera(text, (640, 480))
    assert camera == Camera((500.0, 501.0), (320.0, 240.0), (-0.1, 0.02, 0.0, 0.0), (640, 480))
    with pytest.raises(InputError, match="give --size"):
        read_camera(text)


ROS = """
image_width: 640
image_height: 480
camera_name: camera
camera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.3, 0.1, 0, 0, 0]}
"""


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (ROS, "hello there", "not a (YAML|JSON)|camera_matrix holds 0"),
        (ROS, "{", "not a JSON document"),
        (ROS, "[1, 2", "not a (YAML|JSON)|camera_matrix holds 0"),
        ("500, 0, 320, 0", "500, 0, 320", "camera_matrix holds 8 numbers"),
        ("500, 0, 320, 0", "500, abc, 320, 0", "something else than finite numbers"),
        ("500, 0, 320, 0", "500, 3, 320, 0", "skew"),
        ("plumb_bob", "thin_prism", "distortion_model 'thin_prism' is none of"),
        ("plumb_bob", "equidistant", "5 distortion coefficients"),
        ("image_width: 640", "", "tells no image_width"),
        ("image_width: 640", "image_width: -3", "tells no image_width"),
    ],
)
def test_what_is_no_camera_file(old: str, new: str, words: str) -> None:
    assert read_camera(ROS).focal == (500.0, 500.0)
    with pytest.raises(InputError, match=words):
        read_camera(ROS.replace(old, new))


def test_another_size_than_the_file_tells_is_refused() -> None:
    with pytest.raises(InputError, match="640x480"):
        read_camera(ROS, (320, 240))


def test_an_equidistant_camera_info() -> None:
    text = ROS.replace("plumb_bob", "equidistant").replace("0.1, 0, 0, 0]", "0.1, 0, 0]")
    assert read_camera(text).fisheye
