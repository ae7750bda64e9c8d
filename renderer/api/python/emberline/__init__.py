"""Emberline, a path tracer for glTF scenes. Pictures are NumPy arrays.

    import emberline

    scene = emberline.Scene("shot.glb", size=(640, 360), env="studio.hdr")
    picture = emberline.render(scene, driver="adaptive", noise_threshold=0.01)
    picture["RGB"]                              # float32, (360, 640, 3), linear
    emberline.write("shot.png", picture)

The same scene, edits and settings always give the same bits as the command, whatever the number of threads.
Messages go to logging.getLogger("emberline").
"""

from ._emberline import *
from ._emberline import __version__

for _value in list(globals().values()):
    if getattr(_value, "__module__", None) == "emberline._emberline":
        _value.__module__ = __name__
del _value
