"""The camera as Blender frames it: its own view_frame() knows sensor, shift, fit and pixel aspect.
Also the size of the picture and of the border within it."""

import math

from mathutils import Matrix


def resolution(scene):
    """Size of the full frame in pixels."""
    render = scene.render
    percent = render.resolution_percentage / 100
    return max(1, int(render.resolution_x * percent)), max(1, int(render.resolution_y * percent))


def border(scene, size):
    """The rectangle [x0, y0, x1, y1) to render, in pixels of the full frame, first row at the
    bottom."""
    render, (width, height) = scene.render, size
    if not render.use_border:
        return [0, 0, width, height]
    x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
    y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
    x0, y0 = min(x0, width - 1), min(y0, height - 1)
    return [x0, y0, max(x1, x0 + 1), max(y1, y0 + 1)]


def send_camera(shown, size, rectangle, context):
    """`shown` is the evaluated camera object (any object can be a camera: it is then a perspective
    one)."""
    camera = shown.data if shown.type == 'CAMERA' else None
    scene = context.scene
    if camera is None:
        context.warn(shown, "type", "is no camera: rendered as a perspective one at its place")
    matrix = rigid(shown.matrix_world)
    members = {
        "kind": "orthographic" if camera and camera.type == 'ORTHO' else "perspective",
        "transform": flat(matrix),
        "frame": _frame(camera, scene, size),
        "resolution": list(size),
        "border": rectangle,
        "clip": [camera.clip_start, camera.clip_end] if camera else [0.1, 1000.0],
    }
    if camera and camera.type == 'PANO':
        context.warn(shown, "type", "a panoramic camera is rendered as a perspective one")
    if camera and camera.dof.use_dof:
        members.update(_lens(camera, matrix, context))
    context.send("camera", **members)


def rigid(matrix):
    """Without scale: Blender ignores that of a camera, and a light's is in its size. Mirrored it
    stays, unlike in what decompose() returns: there a mirrored camera looks backwards."""
    axes = [_unit(matrix.col[i]) for i in range(3)]
    if None in axes:  # flattened: any direction does that fits the others
        _, rotation, _ = matrix.decompose()
        axes = [rotation.to_matrix().col[i] for i in range(3)]
    columns = [(*axis, 0.0) for axis in axes] + [matrix.col[3]]
    return Matrix(columns).transposed()


def _unit(column):
    """In double precision, so that every Blender rounds alike; None for nothing."""
    x, y, z = column[:3]
    length = math.sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length) if length > 0 else None


def flat(matrix):
    """The three upper rows: a transform of the stream."""
    return [value for row in matrix[:3] for value in row]


def _frame(camera, scene, size):
    """[left, right, bottom, top] on the plane z = −1, or in metres for an orthographic camera."""
    if camera is None:
        half = 18 / 50  # a 36 mm sensor and a 50 mm lens, as Blender assumes
        return [-half, half, -half * size[1] / size[0], half * size[1] / size[0]]
    corners = camera.view_frame(scene=scene)
    scale = 1.0 if camera.type == 'ORTHO' else -1.0 / corners[0].z
    xs = [corner.x * scale for corner in corners]
    ys = [corner.y * scale for corner in corners]
    return [min(xs), max(xs), min(ys), max(ys)]


def _lens(camera, matrix, context):
    """The thin lens. Aperture of a perspective camera: focal length / (2 · f-stop); of an
    orthographic one, 1 / (2 · f-stop)."""
    dof = camera.dof
    distance = dof.focus_distance
    if dof.focus_object:
        distance = _focus_distance(dof, matrix, context)
    focal = 1.0 if camera.type == 'ORTHO' else camera.lens * 1e-3
    return {
        "lens_radius": focal / (2 * max(dof.aperture_fstop, 1e-5)),
        "focus_distance": max(distance, 1e-5),
        "blades": dof.aperture_blades,
        "blade_rotation": dof.aperture_rotation,
        "aspect": dof.aperture_ratio,
    }


def _focus_distance(dof, matrix, context):
    """Along the view direction to the object, or to the bone of it that is named."""
    target = dof.focus_object.evaluated_get(context.depsgraph)
    place = target.matrix_world
    bone = (
        target.pose.bones.get(dof.focus_subtarget) if target.pose and dof.focus_subtarget else None
    )
    if bone:
        place = place @ bone.matrix
    view = -matrix.col[2].to_3d()
    return math.fabs(view.dot(place.translation - matrix.translation))
