"""Differences between the supported versions of Blender, 3.4 to 5.2. No other module checks the version."""
import bpy
import numpy

# Radiance of an area light in units of P / A (power P, size A). Blender 4.0 replaced 1/4 by 1/pi.
AREA_RADIANCE = 0.25 if bpy.app.version < (4, 0) else 1 / numpy.pi


# Since 4.0 an engine's report() of an error also shows in the window; before, only error_set() did.
REPORT_SHOWS_ERRORS = bpy.app.version >= (4, 0)


def corner_normals(mesh):
    """Normals per face corner, in Blender's axes."""
    normals = numpy.empty((len(mesh.loops), 3), numpy.float32)
    if hasattr(mesh, "corner_normals"):
        mesh.corner_normals.foreach_get("vector", normals.ravel())
    else:  # before 4.1
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals.ravel())
    return normals


def shutter_owner(scene):
    """The object that has `motion_blur_position`."""
    render = scene.render
    return next(owner for owner in (render, getattr(scene, "cycles", None), scene.eevee) if hasattr(owner, "motion_blur_position"))


def update_after_export(depsgraph):
    """Call after a render's export. If relations are still to be rebuilt at the next frame of an animation,
    Blender 5.2 crashes, with any engine."""
    if bpy.app.version >= (5, 0):
        depsgraph.update()


def casts_shadows(light):
    if bpy.app.version < (4, 2):  # in these versions light.use_shadow belongs to EEVEE
        return getattr(getattr(light, "cycles", None), "cast_shadow", True)
    return light.use_shadow
