"""The Emberline add-on; see README.md beside this folder."""

bl_info = {
    "name": "Emberline",
    "author": "The Emberline authors",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "Render Properties > Render Engine",
    "description": "Render with the Emberline path tracer",
    "category": "Render",
}

from . import engine, heatmap, limits, panels, settings  # noqa: E402

_PARTS = (settings, limits, engine, heatmap, panels)


def register():
    for part in _PARTS:
        part.register()


def unregister():
    for part in reversed(_PARTS):
        part.unregister()
