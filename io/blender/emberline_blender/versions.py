"""What differs between the versions of Blender that the add-on runs in, 3.4 to 5.2: nowhere else is a version asked for."""
import bpy
import numpy

# What an area light of P watts and size A has of P / A as its radiance: Blender 4.0 put pi where 4 had been.
AREA_RADIANCE = 0.25 if bpy.app.version < (4, 0) else 1 / numpy.pi


# An engine's report() of an error says it in the window, too; before, error_set() did.
REPORTS_SHOW = bpy.app.version >= (4, 0)


def corner_normals(mesh):
    """Of each corner of a face, in Blender's axes."""
    normals = numpy.empty((len(mesh.loops), 3), numpy.float32)
    if hasattr(mesh, "corner_normals"):
        mesh.corner_normals.foreach_get("vector", normals.ravel())
    else:  # before 4.1
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals.ravel())
    return normals


def shutter_owner(scene):
    """What has `motion_blur_position`."""
    render = scene.render
    return next(owner for owner in (render, getattr(scene, "cycles", None), scene.eevee) if hasattr(owner, "motion_blur_position"))


def data_were_made(depsgraph):
    """To be called after a render's export. Blender 5.2 crashes at the next frame of an animation if its relations are still
    to be made anew then, with any engine."""
    if bpy.app.version >= (5, 0):
        depsgraph.update()


def casts_shadows(light):
    if bpy.app.version < (4, 2):  # there `use_shadow` is EEVEE's
        return getattr(getattr(light, "cycles", None), "cast_shadow", True)
    return light.use_shadow
