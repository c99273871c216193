"""Tables of translators: closures by @translates, volumes by @fills, colours and numbers by
@evaluates, each by node identifier. A Stokes node stands in them as "stokes." and its kind."""

from ... import nodes

CLOSURES = {}  # key -> function(node, graph) -> closure dict or None
VOLUMES = {}  # key -> function(node, graph) -> volume dict or None
VALUES = {}  # key -> function(node, output, graph) -> a value (values.py)


def translates(*keys):
    return _enter(CLOSURES, keys)


def fills(*keys):
    return _enter(VOLUMES, keys)


def evaluates(*keys):
    return _enter(VALUES, keys)


def _enter(table, keys):
    def enter(function):
        for key in keys:
            table[key] = function
        return function

    return enter


def key_of(node):
    kind = nodes.kind_of(node)
    return "stokes." + kind.name if kind else node.bl_idname
