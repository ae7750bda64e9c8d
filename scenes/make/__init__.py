"""The modules behind make_scenes.py: one per scene, and the few things the scenes share."""
