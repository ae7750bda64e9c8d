"""Differences between the supported versions of Blender, 3.4 to 5.2. No other module checks the version."""
import bpy
import numpy

# The radiance of an area light of power P and size A is this factor times P / A. Blender 4.0 replaced 1/4 by 1/pi.
AREA_RADIANCE = 0.25 if bpy.app.version < (4, 0) else 1 / numpy.pi


# Since 4.0, an error that an engine passes to report() also shows in the window. Earlier versions need error_set().
REPORT_SHOWS_ERRORS = bpy.app.version >= (4, 0)


def corner_normals(mesh):
    """Returns the normal of each face corner, in Blender's axes."""
    normals = numpy.empty((len(mesh.loops), 3), numpy.float32)
    if hasattr(mesh, "corner_normals"):
        mesh.corner_normals.foreach_get("vector", normals.ravel())
    else:  # before 4.1
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals.ravel())
    return normals


def shutter_owner(scene):
    """Returns the settings object that has `motion_blur_position`."""
    render = scene.render
    return next(owner for owner in (render, getattr(scene, "cycles", None), scene.eevee) if hasattr(owner, "motion_blur_position"))


def update_after_export(depsgraph):
    """Must be called after a render's export. Otherwise Blender 5.2 crashes, with any engine, because the depsgraph's
    relations are not rebuilt before the next frame of an animation."""
    if bpy.app.version >= (5, 0):
        depsgraph.update()


def casts_shadows(light):
    if bpy.app.version < (4, 2):  # in these versions, only EEVEE uses light.use_shadow
        return getattr(getattr(light, "cycles", None), "cast_shadow", True)
    return light.use_shadow
