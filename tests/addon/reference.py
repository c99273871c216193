"""Prints, inside Blender, the part of the README that lists what a script can set: the engine, its settings, the nodes with
their sockets and settings. `blender -b --factory-startup --python tests/addon/reference.py -- FILE` writes it to FILE."""

import os
import sys

import bpy

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
import addon  # noqa: E402

SKIPPED = {"rna_type", "name", "bl_rna"}
WORDS_MAX = 8  # choices that are spelled out; a longer list is the library's


def value_of(prop):
    if prop.type == 'ENUM':
        names = [item.identifier for item in prop.enum_items]
        return " \\| ".join(names) if len(names) <= WORDS_MAX else "%s, … (%d)" % (names[1], len(names))
    if prop.type == 'BOOLEAN':
        return str(prop.default)
    if prop.type == 'STRING':
        return "text"
    return "%g" % prop.default


def settings(cls):
    rows = []
    for prop in cls.bl_rna.properties:
        if prop.identifier not in SKIPPED and not prop.is_readonly and not prop.is_hidden:
            rows.append("`%s` (%s)" % (prop.identifier, value_of(prop)))
    return ", ".join(rows)


def sockets(kind):
    return ", ".join("%s" % socket.name for socket in kind.inputs) or "–"


def lines():
    scene = bpy.context.scene
    yield "The engine is `STOKES`. Settings are attributes of `scene.stokes`, with their defaults or choices:"
    yield settings(type(scene.stokes)) + "."
    yield ""
    yield "`addon.nodes.new(tree, kind, sockets={…}, **settings)` adds a node. In Blender's `tree.nodes` it is a"
    yield "`ShaderNodeGroup` whose `node.stokes.kind` is the kind and whose `node.stokes.KIND` holds the settings:"
    yield ""
    yield "| kind | in the Add menu | inputs | settings |"
    yield "|---|---|---|---|"
    for kind in addon.nodes.KINDS.values():
        listed = settings(kind.Settings) if kind.Settings else "–"
        yield "| `%s` | %s | %s | %s |" % (kind.name, kind.label, sockets(kind), listed)


def main():
    addon.register()
    path = sys.argv[sys.argv.index("--") + 1]
    with open(path, "w", encoding="utf-8") as out:
        out.write("\n".join(lines()) + "\n")


main()
