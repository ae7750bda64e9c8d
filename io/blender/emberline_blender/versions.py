"""What differs between the versions of Blender that the add-on runs in, 3.4 to 5.2: nowhere else is a version asked for."""
import numpy


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
