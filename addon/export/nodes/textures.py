"""Image and environment textures, their coordinates, and normal maps."""

from mathutils import Euler, Matrix

from .. import images
from .registry import evaluates, key_of
from .values import Constant, Environment, Textured, Varying, as_rgb

_EXTENSIONS = {'REPEAT': "repeat", 'EXTEND': "extend", 'CLIP': "clip", 'MIRROR': "mirror"}
_PROJECTIONS = {"UV": "uv", "Generated": "generated", "Object": "object", "Window": "window"}
_FLAT = (0.5, 0.5, 1.0)  # the colour of no change in a normal map
_MISSING = (1.0, 0.0, 1.0)  # Cycles' own colour of an image that is not there


def flat(matrix):
    """The 12 numbers of STREAM.md: three rows."""
    return [matrix[row][column] for row in range(3) for column in range(4)]


def _image(node, graph, times_alpha):
    """Its name in the stream. Cycles multiplies colours by alpha, unless alpha is used beside
    them."""
    if node.image is None:
        graph.warn(node, "has no image; Cycles' magenta is used")
        return None
    if times_alpha and images.is_sheer(node.image):
        return graph.context.image(node.image, times_alpha=True)
    return graph.context.image(node.image)


@evaluates("ShaderNodeTexImage")
def image_texture(node, output, graph):
    alpha_is_used = any(each.is_linked for each in node.outputs if each.identifier == "Alpha")
    name = _image(node, graph, not alpha_is_used)
    if name is None:
        return Constant(_MISSING if output.identifier == "Color" else 1.0)
    if node.projection != 'FLAT':
        graph.warn(
            node,
            "the projection %s is not supported yet; flat coordinates are used"
            % node.projection.lower(),
        )
    if node.interpolation not in {'Linear', 'Closest'}:
        graph.warn(
            node,
            "the interpolation %s is not supported yet; linear is used"
            % node.interpolation.lower(),
        )
    projection, uv_name, matrix = coordinates(graph.input(node, "Vector"), graph)
    texture = {
        "image": name,
        "uv": uv_name,
        "transform": flat(matrix),
        "projection": projection,
        "interpolation": "closest" if node.interpolation == 'Closest' else "linear",
        "extension": _EXTENSIONS.get(node.extension, "repeat"),
    }
    if output.identifier == "Alpha":
        return Varying({"texture": dict(texture, channel="alpha")})
    return Textured(dict(texture, channel="color"), 1.0)


@evaluates("ShaderNodeTexEnvironment")
def environment_texture(node, output, graph):
    name = _image(node, graph, True)
    if name is None:
        return Constant(_MISSING)
    if node.projection != 'EQUIRECTANGULAR':
        graph.warn(
            node,
            "the projection %s is not supported yet; equirectangular is used"
            % node.projection.lower(),
        )
    _projection, _uv, matrix = coordinates(graph.input(node, "Vector"), graph)
    return Environment(name, flat(matrix), 1.0)


def coordinates(socket, graph):
    """(projection, UV layer, matrix) of what feeds a Vector input."""
    node, output, path = graph.follow(socket, graph.path)
    if node is None:
        return "uv", "", Matrix.Identity(4)
    with graph.inside(path):
        find = _COORDINATES.get(key_of(node))
        if find is None:
            graph.warn(node, "is not supported as texture coordinate yet; the UV map is used")
            return "uv", "", Matrix.Identity(4)
        return find(node, output, graph)


def _texture_coordinate(node, output, graph):
    projection = _PROJECTIONS.get(output.identifier)
    if projection is None:
        graph.warn(node, "%s coordinates are not supported yet; the UV map is used" % output.name)
    if node.from_instancer:
        graph.warn(
            node, "coordinates from the instancer are not supported yet; the object's own are used"
        )
    matrix = Matrix.Identity(4)
    if projection == "object" and node.object is not None:
        graph.warn(
            node, "coordinates of another object are not supported yet; the object's own are used"
        )
    return projection or "uv", "", matrix


def _uv_map(node, _output, graph):
    if node.from_instancer:
        graph.warn(
            node, "coordinates from the instancer are not supported yet; the object's own are used"
        )
    return "uv", node.uv_map, Matrix.Identity(4)


def _attribute(node, _output, graph):
    if node.attribute_type != 'GEOMETRY':
        graph.warn(
            node,
            "attributes of the %s are not supported as coordinates; the UV map is used"
            % node.attribute_type.lower(),
        )
        return "uv", "", Matrix.Identity(4)
    return "uv", node.attribute_name, Matrix.Identity(4)


def _mapping(node, _output, graph):
    projection, uv_name, inner = coordinates(graph.input(node, "Vector"), graph)
    location = Matrix.Translation(
        graph.vector(node, "Location") if graph.socket(node, "Location") else (0, 0, 0)
    )
    rotation = Euler(graph.vector(node, "Rotation")).to_matrix().to_4x4()
    scale = Matrix.Diagonal((*graph.vector(node, "Scale"), 1.0))
    if node.vector_type == 'NORMAL':
        graph.warn(node, "the type Normal is not supported for coordinates; Point is used")
    if node.vector_type == 'VECTOR':
        own = rotation @ scale
    elif node.vector_type == 'TEXTURE':
        own = location @ rotation @ scale
        if own.determinant() == 0.0:
            graph.warn(node, "a scale of 0 cannot be undone; the coordinates are left as they are")
            own = Matrix.Identity(4)
        own = own.inverted()
    else:
        own = location @ rotation @ scale
    return projection, uv_name, own @ inner


def _vector_math(node, _output, graph):
    projection, uv_name, inner = coordinates(node.inputs[0], graph)
    if node.operation == 'SCALE':
        own = Matrix.Diagonal((*(graph.number(node, "Scale"),) * 3, 1.0))
    elif node.operation in {'ADD', 'SUBTRACT', 'MULTIPLY'}:
        value = graph.value(node.inputs[1])
        if not isinstance(value, Constant):
            graph.warn(
                node, "two varying vectors are not supported as coordinates; the first is used"
            )
            return projection, uv_name, inner
        vector = as_rgb(value.value)
        sign = -1.0 if node.operation == 'SUBTRACT' else 1.0
        own = (
            Matrix.Diagonal((*vector, 1.0))
            if node.operation == 'MULTIPLY'
            else Matrix.Translation([sign * v for v in vector])
        )
    else:
        graph.warn(
            node,
            "%s is not supported for coordinates; they are left as they are"
            % node.operation.lower(),
        )
        own = Matrix.Identity(4)
    return projection, uv_name, own @ inner


_COORDINATES = {
    "ShaderNodeTexCoord": _texture_coordinate,
    "ShaderNodeUVMap": _uv_map,
    "ShaderNodeAttribute": _attribute,
    "ShaderNodeMapping": _mapping,
    "ShaderNodeVectorMath": _vector_math,
}


def normal(node, graph):
    """The `normal` member of a BSDF: {"texture", "strength"}, or None."""
    socket = graph.socket(node, "Normal")
    return _normal_of(socket, graph) if socket is not None else None


def _normal_of(socket, graph):
    node, _output, path = graph.follow(socket, graph.path)
    if node is None:
        return None
    with graph.inside(path):
        if node.bl_idname == "ShaderNodeNormalMap":
            return _normal_map(node, graph)
        if node.bl_idname == "ShaderNodeBump":
            graph.warn(node, "bumps are not supported yet and left out")
            return _normal_of(graph.input(node, "Normal"), graph)
        if node.bl_idname != "ShaderNodeNewGeometry":
            graph.warn(node, "is not supported as normal yet; the surface's own is used")
        return None


def _normal_map(node, graph):
    if node.space != 'TANGENT':
        graph.warn(
            node,
            "the space %s is not supported yet; the surface's own normal is used"
            % node.space.lower(),
        )
        return None
    color = graph.value(graph.input(node, "Color"))
    if not isinstance(color, Textured):
        if not isinstance(color, Constant) or as_rgb(color.value) != _FLAT:
            graph.warn(node, "its colour must be an image; the surface's own normal is used")
        return None
    return {"texture": color.texture, "strength": graph.number(node, "Strength")}
