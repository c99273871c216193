"""The stream's writer and the client of `stokes serve`. Imports no bpy: pipeline scripts use it
alone:

from stokes.core import stream
with stream.Recorder("grey.stokes") as out:
    out.send("world", kind="constant", emission={"rgb": [1, 1, 1], "scale": 1})
    out.send("camera", kind="perspective", transform=stream.IDENTITY, frame=[-1, 1, -1, 1],
    resolution=[8, 8]) out.send("render", samples=[0, 16])
"""
