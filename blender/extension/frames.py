# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames: in Blender z points up, in unrender y; cameras in both.

A point (x, y, z) of Blender is (x, z, -y) in unrender. Pixels count from the picture's top left
corner.
"""

import math

import numpy as np
import unrender
from mathutils import Matrix, Vector

# From unrender's frame to Blender's.
Z_UP = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
# A camera that looks along +y and is upright.
LEVEL = Matrix.Rotation(math.radians(90.0), 4, "X")


def y_up(vectors):
    """Rows (N, 3) of Blender in the frame of unrender."""
    vectors = np.asarray(vectors, dtype=np.float64).reshape(-1, 3)
    return np.stack([vectors[:, 0], vectors[:, 2], -vectors[:, 1]], axis=1)


def y_up_one(vector):
    """One vector of Blender in the frame of unrender."""
    return tuple(float(x) for x in y_up([vector])[0])


def z_up_one(vector):
    """One vector of unrender in Blender's frame."""
    x, y, z = (float(x) for x in vector)
    return (x, -z, y)


def camera_of(thing, depsgraph, size):
    """The camera object ``thing`` as a camera of unrender, for a picture of ``size`` (width,
    height).

    The projection matrix contains the effects of sensor, fit and shift: ``[Blender manual, Cameras;
    OpenGL, perspective matrix]``.
    """
    width, height = size
    projection = thing.calc_matrix_camera(depsgraph, x=width, y=height, scale_x=1.0, scale_y=1.0)
    axes = thing.matrix_world.to_3x3()
    axes.normalize()
    eye = thing.matrix_world.translation
    # The axis is at the image of (0, 0, -1), in half widths and half heights from the centre.
    right, up = -projection[0][2], -projection[1][2]
    return unrender.Camera(
        eye=y_up_one(eye),
        target=y_up_one(eye - axes.col[2]),
        up=y_up_one(axes.col[1]),
        fov_y_deg=math.degrees(2.0 * math.atan(1.0 / projection[1][1])),
        principal_point=(0.5 * right * width / height, -0.5 * up),
        name="photo",
    )


def place_camera(thing, camera):
    """Gives the camera object ``thing`` the pose and lens of ``camera`` of unrender."""
    eye, target, up = (Vector(z_up_one(v)) for v in (camera.eye, camera.target, camera.up))
    back = (eye - target).normalized()
    right = up.cross(back).normalized()
    axes = Matrix((right, back.cross(right), back)).transposed()
    data = thing.data
    data.type = "PERSP"
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(camera.fov_y_deg)
    # If the axis is right of the middle, the frame is shifted to the left, in heights of it.
    data.shift_x, data.shift_y = -camera.principal_point[0], camera.principal_point[1]
    # Set last, since a parent or a constraint must not change it.
    thing.matrix_world = Matrix.Translation(eye) @ axes.to_4x4()
