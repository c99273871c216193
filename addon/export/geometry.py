"""An evaluated mesh into one `mesh` message: foreach_get into arrays, never a loop over vertices.
Names of the API that changed between Blender 3.4 and 5.x are asked for here only."""

from array import array

from ..core.stream import Blob


def floats(count):
    return array("f", bytes(4 * count))


def _integers(count):
    return array("i", bytes(4 * count))


def _get(collection, attribute, values):
    collection.foreach_get(attribute, values)
    return values


def send_mesh(mesh, name, context):
    """Sends `mesh` (a bpy Mesh, evaluated). Returns the highest material index, or None if it has
    no faces."""
    mesh.calc_loop_triangles()
    triangles = mesh.loop_triangles
    count = len(triangles)
    if not count:
        return None
    indices = _get(triangles, "material_index", _integers(count))
    members = {
        "name": name,
        "positions": Blob(_positions(mesh)),
        "triangles": Blob(_get(triangles, "vertices", _integers(3 * count))),
        "corners": Blob(_get(triangles, "loops", _integers(3 * count))),
        "uv": [{"name": layer.name, "data": Blob(_uvs(mesh, layer))} for layer in _uv_layers(mesh)],
        "material_index": Blob(indices),
    }
    if not _is_flat(mesh):
        members["corner_normals"] = Blob(_corner_normals(mesh))
    context.send("mesh", **members)
    return max(indices)


def _positions(mesh):
    values = floats(3 * len(mesh.vertices))
    attribute = mesh.attributes.get("position")  # since 3.5, three times as fast
    if attribute:
        return _get(attribute.data, "vector", values)
    return _get(mesh.vertices, "co", values)


def _is_flat(mesh):
    """All faces flat: the core's own geometric normals serve, for every triangle of a bent quad
    too, as in Cycles."""
    if hasattr(mesh, "normals_domain"):
        return mesh.normals_domain == 'FACE'
    if mesh.has_custom_normals:
        return False
    smooth = array("b", bytes(len(mesh.polygons)))
    return not any(_get(mesh.polygons, "use_smooth", smooth))


def _corner_normals(mesh):
    values = floats(3 * len(mesh.loops))
    if hasattr(mesh, "corner_normals"):
        return _get(mesh.corner_normals, "vector", values)
    mesh.calc_normals_split()
    try:
        return _get(mesh.loops, "normal", values)
    finally:
        mesh.free_normals_split()


def _uv_layers(mesh):
    """The layer that renders comes first: it is the one meant by a texture that names none."""
    return sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)


def _uvs(mesh, layer):
    values = floats(2 * len(mesh.loops))
    if hasattr(layer, "uv"):
        return _get(layer.uv, "vector", values)
    return _get(layer.data, "uv", values)
